#include <algorithm>
#include <chrono>
#include <cstdint>
#include <ctime>
#include <deque>
#include <map>
#include <random>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/client/ask_daemon.h"
#include "app/mqtt/report.h"
#include "tests/loopback/loopback.h"

/// Whoever tells something of a part tells the same: the status, the changes, the metrics, the
/// commands, the log and MQTT, asked for the same moment of the built program.
namespace tribus::test::tellers_test {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;

/// Two receivers, of which the first one counts more, and servos.
class Tellers : public Loopback {
  protected:
    /// What was told while nothing changed.
    struct Told {
        json status;
        json changes;
        std::string metrics;
        std::string text;
        std::string monitor;
        json summary;
    };

    std::string socket() const { return folder() / "control"; }
    json ask(const std::string& request) const {
        return ask_daemon(socket(), request, 10s).value_or(json());
    }
    std::string printed(std::vector<std::string> arguments) {
        arguments.insert(arguments.begin() + 1, {"--socket", socket()});
        Program& asked = start(arguments);
        EXPECT_TRUE(eventually([&] {
            turn();
            return !asked.runs();
        }));
        return asked.output();
    }
    void turn() {
        for (Receiver& receiver : receivers_) {
            if (receiver.sends) {
                receiver.repeater.send_if_due();
            }
        }
        if (servos_.descriptor() >= 0) {
            servos_.receive();
        }
    }
    void turn_for(Clock::duration time) {
        const auto end = Clock::now() + time;
        while (Clock::now() < end) {
            turn();
            constexpr timespec kPause{.tv_sec = 0, .tv_nsec = 1'000'000};
            ::nanosleep(&kPause, nullptr);
        }
    }
    /// Asks everybody again until nothing has changed from the first question to the last.
    Told ask_everybody() {
        Told told;
        EXPECT_TRUE(eventually([&] {
            turn_for(300ms);
            told.status = ask("status");
            told.changes = ask("changes " + std::to_string(told_until_));
            told.metrics = ask("metrics")["text"];
            told.text = printed({"status"});
            told.summary = json::parse(printed({"status", "--format", "json"}), nullptr, false);
            told.monitor = printed({"monitor", "--once"});
            const json after = ask("status");
            return after["changes"] == told.status["changes"] &&
                   told.changes["newest"] == told.status["changes"];
        }));
        for (const json& change : told.changes["changes"]) {
            told_until_ = change["number"];
            const std::string part =
                std::string(change["part"]) + " " + std::string(change["name"]);
            sentences_.insert(change["text"]);
            if (change["field"] == "cause" || change["field"] == "state") {
                words_[part] = change["now"];
            }
            if (change["part"] == "output") {
                inputs_[part] = change["input"];
            }
        }
        return told;
    }

    void expect_agreement_of_input(const Told& told, const json& input) {
        const std::string name = input["name"];
        const std::string cause = input["cause"];
        const std::string text = input["text"];
        if (words_.contains("input " + name)) {
            EXPECT_EQ(words_["input " + name], cause);
        }
        EXPECT_NE(told.metrics.find("input=\"" + name + "\",cause=\"" + cause + "\"} 1"),
                  std::string::npos)
            << cause << '\n'
            << told.metrics;
        EXPECT_NE(told.text.find("input " + name + ": " + text + ","), std::string::npos)
            << told.text;
        const json payload = json::parse(mqtt::status_payload(told.status));
        EXPECT_EQ(payload["inputs"][name]["cause"], cause);
        EXPECT_EQ(payload["inputs"][name]["good"], input["good"]);
        EXPECT_EQ(input["good"], cause == "good");
        const auto& summed = named(told.summary["inputs"], name);
        EXPECT_EQ(summed["cause"], cause);
        EXPECT_EQ(summed["text"], text);
    }
    void expect_agreement_of_output(const Told& told, const json& output) {
        const std::string name = output["name"];
        const std::string state = output["state"];
        if (words_.contains("output " + name)) {
            EXPECT_EQ(words_["output " + name], state);
            EXPECT_EQ(inputs_["output " + name], output["input"]);
        }
        EXPECT_NE(told.metrics.find("output=\"" + name + "\",state=\"" + state + "\"} 1"),
                  std::string::npos)
            << told.metrics;
        const std::string line = "output " + name + ": " + std::string(output["text"]);
        EXPECT_NE(told.text.find(line), std::string::npos) << line << '\n' << told.text;
        const json payload = json::parse(mqtt::status_payload(told.status));
        EXPECT_EQ(payload["outputs"][name]["state"], state);
        EXPECT_EQ(payload["outputs"][name]["input"], output["input"]);
        EXPECT_EQ(payload["outputs"][name]["obstacle"], output["obstacle"]);
        const auto& summed = named(told.summary["outputs"], name);
        EXPECT_EQ(summed["state"], state);
        EXPECT_EQ(summed["text"], output["text"]);
        EXPECT_EQ(summed["input"], output["input"]);
        std::string shown = state;
        std::ranges::replace(shown, '_', ' ');
        EXPECT_NE(told.monitor.find(state == "control" && output["input"].is_string()
                                        ? "control of " + std::string(output["input"])
                                        : shown),
                  std::string::npos)
            << told.monitor;
    }
    void expect_agreement_of_device(const Told& told, const json& port) {
        const std::string name = port["name"];
        const bool present = port["present"];
        if (words_.contains("device " + name)) {
            EXPECT_EQ(words_["device " + name], present ? "there" : "gone");
        }
        EXPECT_NE(told.text.find("device " + name + (present ? ": there" : ": gone")),
                  std::string::npos)
            << told.text;
        EXPECT_NE(told.metrics.find("port=\"" + name + "\"} " + (present ? "1" : "0")),
                  std::string::npos);
        EXPECT_EQ(json::parse(mqtt::status_payload(told.status))["devices"][name]["present"],
                  present);
    }
    /// Each line of the log about a part is the sentence of a change, perhaps with a note behind.
    void expect_the_sentences_in(const std::string& log) {
        static const std::regex pattern(
            "[0-9:.]+ (?:info|warning) ((?:input|output|device) .*?)(?: \\([0-9]+ changes? before "
            "this not logged.*)?");
        std::istringstream lines(log);
        std::smatch found;
        for (std::string line; std::getline(lines, line);) {
            const bool besides = line.find("dropped because") != std::string::npos ||
                                 line.find("no byte yet") != std::string::npos;
            if (!besides && std::regex_match(line, found, pattern)) {
                EXPECT_TRUE(sentences_.contains(found[1])) << line;
            }
        }
    }
    static const json& named(const json& list, const std::string& name) {
        static const json nothing;
        const auto found =
            std::ranges::find_if(list, [&](const json& one) { return one["name"] == name; });
        return found == list.end() ? nothing : *found;
    }

    struct Receiver {
        FarEnd& line;
        Repeater repeater;
        bool sends = true;
    };
    std::deque<Receiver> receivers_;
    FarEnd& servos_ = device("servos");
    std::uint64_t told_until_ = 0;
    std::map<std::string, std::string> words_;
    std::map<std::string, json> inputs_;
    std::set<std::string> sentences_;
};

TEST_F(Tellers, AgreeOfEveryPartWhateverHappens) {
    for (const char* name : {"main", "backup"}) {
        FarEnd& line = device(name);
        receivers_.push_back({line, Repeater(line, ibus_bytes(Sticks(14, 1500)))});
    }
    Program& program = run(write_config(R"([input.main]
protocol = "ibus"
device = "@main"
[input.backup]
protocol = "ibus"
device = "@backup"
[output.servos]
protocol = "sbus"
device = "@servos"
[pipeline.main]
from = ["main", "backup"]
to = "servos"
)"));
    std::vector<bool> plugged{true, true, true};
    std::mt19937 random(5);
    const auto toggle_plug = [&](std::size_t which) {
        FarEnd& line = which < 2 ? receivers_[which].line : servos_;
        plugged[which] ? line.pull() : line.plug_in();
        plugged[which] = !plugged[which];
    };
    constexpr int kSteps = 12;
    for (int step = 0; step < kSteps; ++step) {
        const std::size_t which = random() % 3;
        const bool plug = which == 2 || random() % 3 == 0;
        SCOPED_TRACE(fmt::format("step {}: {} {}", step, plug ? "plug" : "silence", which));
        if (plug) {
            toggle_plug(which);
        } else {
            receivers_[which].sends = !receivers_[which].sends;
        }
        const Told told = ask_everybody();
        for (const json& input : told.status["inputs"]) {
            expect_agreement_of_input(told, input);
        }
        for (const json& output : told.status["outputs"]) {
            expect_agreement_of_output(told, output);
        }
        for (const json& port : told.status["ports"]) {
            expect_agreement_of_device(told, port);
        }
    }
    EXPECT_GT(words_.size(), 3U) << "too little has happened";
    expect_the_sentences_in(program.errors());
    expect_clean_end(program);
}

}  // namespace
}  // namespace tribus::test::tellers_test
