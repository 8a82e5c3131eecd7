#include <algorithm>
#include <array>
#include <random>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/monitor/monitor_lines.h"
#include "app/mqtt/report.h"
#include "app/state_text/cause_text.h"
#include "app/status/metrics_text.h"
#include "app/status/status.h"
#include "app/status/status_json.h"
#include "app/status_command/summary.h"
#include "config/language/mistakes.h"
#include "config/load.h"
#include "core/link_cause.h"

/// Whoever tells something of a part says the same as the status: for random configurations in
/// random states. (tests/loopback/tellers_test.cpp asks the built program, and reads its log.)
namespace tribus::agreement_test {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;

constexpr std::array<std::string_view, 2> kPresences{"there", "gone"};
const Instant kNow{1000s};

/// Inputs and outputs of random protocols, with pipelines between them.
class RandomReport {
  public:
    explicit RandomReport(unsigned seed) : random_(seed), configuration_(loaded(text())) {
        report_.configuration = &configuration_;
        report_.now = kNow;
        report_.started = kNow - 100s;
        report_.figures_at = kNow - 40ms;
        for (std::size_t i = 0; i < configuration_.inputs.size(); ++i) {
            report_.inputs.push_back(input());
        }
        for (std::size_t i = 0; i < configuration_.outputs.size(); ++i) {
            report_.outputs.push_back(output(configuration_.pipelines[i].selection.inputs));
        }
        for (const char* name : {"/dev/ttyS1", "can0", "/dev/ttyS2"}) {
            const bool is_can = std::string_view(name) == "can0";
            report_.ports.push_back({name, flip(), {}});
            if (is_can) {
                report_.ports.back().can = CanLinkStatus{one_of<CanBusState>(6), {}};
            }
        }
    }
    RandomReport(const RandomReport&) = delete;
    RandomReport& operator=(const RandomReport&) = delete;
    const StatusReport& report() const { return report_; }

  private:
    std::size_t below(std::size_t most) { return random_() % most; }
    bool flip() { return below(2) == 0; }
    template <class Choice>
    Choice one_of(std::size_t count) {
        return static_cast<Choice>(below(count));
    }
    Instant moment() { return kNow - std::chrono::milliseconds(below(100'000)); }

    static Configuration loaded(const std::string& text) {
        auto configuration = load_configuration(text, "/etc/tribus/car.toml");
        EXPECT_TRUE(configuration) << format_mistake(configuration.error().front()) << '\n' << text;
        return configuration.value_or(Configuration());
    }
    /// Each input is of use: the first pipeline has all of them.
    std::string text() {
        static constexpr std::array<std::string_view, 4> kProtocols{"ibus", "sbus", "crsf", "sumd"};
        const std::size_t inputs = 1 + below(4);
        const std::size_t outputs = 1 + below(3);
        std::string text;
        for (std::size_t i = 0; i < inputs; ++i) {
            text += fmt::format("[input.in{}]\nprotocol = \"{}\"\ndevice = \"/dev/ttyS1{}\"\n", i,
                                kProtocols[below(4)], i);
        }
        for (std::size_t o = 0; o < outputs; ++o) {
            text += fmt::format("[output.out{}]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyS2{}\"\n",
                                o, o);
        }
        for (std::size_t o = 0; o < outputs; ++o) {
            std::string from;
            for (std::size_t i = 0; i < inputs; ++i) {
                from += o == 0 || i == o % inputs || flip() ? fmt::format("\"in{}\", ", i) : "";
            }
            text += fmt::format("[pipeline.p{}]\nfrom = [{}]\nto = \"out{}\"\n", o, from, o);
        }
        return text;
    }
    InputReport input() {
        InputReport input;
        input.status.state = {.cause = one_of<LinkCause>(kLinkCauseWords.size()),
                              .sign = one_of<RadioLossSign>(5),
                              .since = moment()};
        input.status.latest.frame_lost = flip();
        input.status.counts.frames = below(3);
        input.status.newest_at = moment();
        return input;
    }
    OutputReport output(const std::vector<std::size_t>& inputs) {
        OutputReport output;
        output.inputs = inputs;
        OutputState& state = output.status.state;
        state.stage = one_of<OutputStage>(4);
        output.status.stage_since = moment();
        output.status.sends = flip();
        if (state.stage == OutputStage::control) {
            state.input = inputs[below(inputs.size())];
            return output;
        }
        if (state.stage == OutputStage::cannot_send) {
            state.obstacle = static_cast<SendObstacle>(1 + below(5));
            return output;
        }
        output.status.wait = {.awaited = static_cast<Awaited>(1 + below(11)),
                              .input = inputs[below(inputs.size())],
                              .so_far = 200ms,
                              .needed = 500ms};
        output.status.wait.link = report_.inputs[*output.status.wait.input].status.state;
        state.forced = flip();
        state.awaits_release = !state.forced && flip();
        return output;
    }

    std::mt19937 random_;
    Configuration configuration_;
    StatusReport report_;
};

class Agreement : public testing::TestWithParam<unsigned> {
  protected:
    /// That a text has this word of a list, with blanks for underscores, and no other one of it.
    static void expect_only(std::string_view said, std::string_view word,
                            std::span<const std::string_view> words) {
        const auto has = [&](std::string_view wanted) {
            std::string shown(wanted);
            std::ranges::replace(shown, '_', ' ');
            return (" " + std::string(said) + " ").find(" " + shown + " ") != std::string::npos;
        };
        EXPECT_TRUE(has(word)) << '"' << said << "\" lacks " << word;
        for (const std::string_view other : words) {
            const bool part = word.find(other) != std::string_view::npos;
            EXPECT_TRUE(part || !has(other))
                << '"' << said << "\" says " << other << ", not " << word;
        }
    }
    /// That exactly this word of a list has the value 1 in the metrics.
    void expect_metric(const std::string& part, const std::string& label, std::string_view word,
                       std::span<const std::string_view> words) const {
        for (const std::string_view one : words) {
            const std::string sample =
                fmt::format("{},{}=\"{}\"}} {}\n", part, label, one, one == word ? 1 : 0);
            EXPECT_NE(metrics_.find(sample), std::string::npos) << sample << metrics_;
        }
    }
    bool has_line(const std::string& begin) const {
        return std::ranges::any_of(
            lines_, [&](const std::string& line) { return (line + ",;").starts_with(begin); });
    }

    const RandomReport random_{GetParam()};
    const json status_ = json::parse(status_json(random_.report()));
    const std::string metrics_ = metrics_text(random_.report());
    const json payload_ = json::parse(mqtt::status_payload(status_));
    const nlohmann::ordered_json summary_ = status_summary::of_status(status_).value();
    const std::vector<std::string> lines_ = status_summary::lines(summary_);
};

TEST_P(Agreement, InputsAreToldAlike) {
    for (std::size_t i = 0; i < status_["inputs"].size(); ++i) {
        const json& input = status_["inputs"][i];
        const std::string name = input["name"];
        const std::string cause = input["cause"];
        SCOPED_TRACE(input.dump());
        EXPECT_EQ(input["good"], cause == "good");
        const std::string text = input["text"];
        EXPECT_TRUE(text.starts_with(name_of(random_.report().inputs[i].status.state.cause)));
        expect_metric("input=\"" + name + '"', "cause", cause, kLinkCauseWords);
        const bool marked = cause == "good" && input["state"] == "frame_lost";
        expect_only(monitor::input_state(input), marked ? "frame_lost" : cause, kLinkCauseWords);
        EXPECT_EQ(payload_["inputs"][name]["cause"], cause);
        EXPECT_EQ(payload_["inputs"][name]["good"], input["good"]);
        EXPECT_EQ(summary_["inputs"][i]["cause"], cause);
        EXPECT_EQ(summary_["inputs"][i]["good"], input["good"]);
        EXPECT_TRUE(has_line("input " + name + ": " + text + ","));
    }
}

TEST_P(Agreement, OutputsAreToldAlike) {
    for (std::size_t i = 0; i < status_["outputs"].size(); ++i) {
        const json& output = status_["outputs"][i];
        const std::string name = output["name"];
        const std::string state = output["state"];
        SCOPED_TRACE(output.dump());
        EXPECT_EQ(output["input"].is_string(), state == "control");
        EXPECT_EQ(output["obstacle"].is_string(), state == "cannot_send");
        EXPECT_EQ(output["waits_for"].is_null(), state == "control");
        expect_metric("output=\"" + name + '"', "state", state, kOutputStateWords);
        expect_only(monitor::output_state(output), state, kOutputStateWords);
        for (const char* field : {"state", "input", "obstacle", "waits_for"}) {
            EXPECT_EQ(payload_["outputs"][name][field], output[field]) << field;
            EXPECT_EQ(json(summary_["outputs"][i][field]), output[field]) << field;
        }
        EXPECT_TRUE(has_line("output " + name + ": " + std::string(output["text"])));
    }
}

/// The sentence of each state is told from those of the others.
TEST_P(Agreement, SentencesFitTheirStates) {
    static const std::vector<std::pair<std::string_view, std::string_view>> sentences{
        {"control", "under control of "},
        {"hold", "holding the last values"},
        {"failsafe", "in failsafe"},
        {"silent", "in failsafe"},
        {"cannot_send", "cannot send: "}};
    for (const json& output : status_["outputs"]) {
        const std::string text = output["text"];
        const std::string why = output["why"].is_null() ? "" : std::string(output["why"]);
        for (const auto& [state, sentence] : sentences) {
            EXPECT_TRUE(state != output["state"] || text.starts_with(sentence)) << output;
        }
        EXPECT_EQ(why.find("it sends its presets") != std::string::npos,
                  output["state"] == "failsafe");
        EXPECT_EQ(why.find("it sends nothing") != std::string::npos, output["state"] == "silent");
        EXPECT_EQ(why.find("waits for") != std::string::npos, output["state"] != "control")
            << output;
    }
}

TEST_P(Agreement, DevicesAreToldAlike) {
    for (std::size_t i = 0; i < status_["ports"].size(); ++i) {
        const json& port = status_["ports"][i];
        const std::string name = port["name"];
        SCOPED_TRACE(port.dump());
        const std::string_view presence = kPresences[port["present"] == true ? 0 : 1];
        EXPECT_NE(
            metrics_.find(fmt::format("port=\"{}\"}} {}\n", name, port["present"] == true ? 1 : 0)),
            std::string::npos);
        EXPECT_EQ(payload_["devices"][name]["present"], port["present"]);
        const std::string told = summary_["devices"][i]["state"];
        EXPECT_TRUE(told == presence || told == port["can"]["state"]) << told;
        EXPECT_EQ(told == "gone", presence == "gone");
        EXPECT_TRUE(has_line("device " + name + ": " + told));
        const std::string line = monitor::port_line(port, {});
        EXPECT_EQ(line.find("GONE") != std::string::npos, presence == "gone") << line;
    }
}

INSTANTIATE_TEST_SUITE_P(Random, Agreement, testing::Range(0U, 150U));

}  // namespace
}  // namespace tribus::agreement_test
