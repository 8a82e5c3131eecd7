#include <regex>
#include <set>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

#include "app/status/metrics_text.h"
#include "config/load.h"

namespace tribus::metrics_test {
namespace {

constexpr const char* kConfig = R"([input.main]
protocol = "ibus"
device   = "/dev/tty\"A\\2"
[output.servos]
protocol = "sbus"
device   = "/dev/ttyAMA3"
[pipeline.car]
from = "main"
to   = "servos"
)";

class Metrics : public testing::Test {
  protected:
    Metrics() : configuration_(*load_configuration(kConfig, "car.toml")) {
        report_.configuration = &configuration_;
        report_.now = Instant(std::chrono::seconds(100));
        report_.started = Instant(std::chrono::seconds(90));
        report_.figures_at = Instant(std::chrono::milliseconds(99'950));
        report_.inputs.resize(1);
        report_.inputs[0].status.counts.frames = 42;
        report_.inputs[0].reject_causes = {"other source"};
        report_.inputs[0].status.rejected_by = {3};
        report_.inputs[0].status.state.cause = LinkCause::radio_lost;
        report_.outputs.resize(1);
        report_.outputs[0].status.sends = true;
        report_.ports = {{"/dev/tty\"A\\2\n", true, {}},
                         {"can0", false, CanLinkStatus{CanBusState::ready, {}}},
                         {"can1", true, CanLinkStatus{CanBusState::bus_off, {.bus_offs = 2}}}};
        const NamedValue value{.name = "pack.voltage", .unit = "V", .lasts = kForever};
        report_.values = {
            {value, {.number = 12.5, .at = report_.now, .ever = true, .available = true}},
            {value, {}}};
    }
    /// The labels `label` of those samples of a family that are 1.
    std::set<std::string> ones(const std::string& family, const std::string& label) const {
        const std::regex sample(family + "\\{.*" + label + "=\"([^\"]*)\".*\\} 1");
        std::set<std::string> found;
        std::istringstream text(metrics_text(report_));
        for (std::string line; std::getline(text, line);) {
            if (std::smatch match; std::regex_match(line, match, sample)) {
                found.insert(match[1]);
            }
        }
        return found;
    }
    bool tells(const std::string& line) const {
        return ("\n" + metrics_text(report_)).find("\n" + line + "\n") != std::string::npos;
    }

    Configuration configuration_;
    StatusReport report_;
};

TEST_F(Metrics, FiguresThatNeverCameAreAsOldAsTheProgram) {
    report_.figures_at = Instant{};
    EXPECT_TRUE(tells("tribus_figures_age_seconds{daemon=\"car\"} 10")) << metrics_text(report_);
}

TEST_F(Metrics, CountLossesThatNeverCameAsZero) {
    report_.inputs[0].status.counts.began[static_cast<std::size_t>(LinkCause::late)] = 2;
    const std::string losses = "tribus_input_losses_total{daemon=\"car\",input=\"main\",cause=\"";
    EXPECT_TRUE(tells(losses + "late\"} 2"));
    EXPECT_TRUE(tells(losses + "forged\"} 0"));
    EXPECT_TRUE(tells(losses + "wire_silent\"} 0"));
}

TEST_F(Metrics, CountByName) {
    EXPECT_TRUE(tells("tribus_input_frames_total{daemon=\"car\",input=\"main\"} 42"))
        << metrics_text(report_);
    EXPECT_TRUE(tells(
        "tribus_input_rejected_total{daemon=\"car\",input=\"main\",cause=\"other_source\"} 3"));
    EXPECT_TRUE(tells("tribus_output_in_control{daemon=\"car\",output=\"servos\"} 0"));
    EXPECT_TRUE(tells("tribus_figures_age_seconds{daemon=\"car\"} 0.05"));
}

TEST_F(Metrics, EscapeWhatStandsInLabels) {
    EXPECT_TRUE(tells(R"(tribus_port_present{daemon="car",port="/dev/tty\"A\\2\n"} 1)"))
        << metrics_text(report_);
}

using Words = std::set<std::string>;

TEST_F(Metrics, TellThePresentCauseOfAnInput) {
    EXPECT_EQ(ones("tribus_input_cause", "cause"), Words{"radio_lost"}) << metrics_text(report_);
    EXPECT_TRUE(tells(R"(tribus_input_cause{daemon="car",input="main",cause="good"} 0)"));
    report_.inputs[0].status.state.cause = LinkCause::good;
    EXPECT_EQ(ones("tribus_input_cause", "cause"), Words{"good"});
}

TEST_F(Metrics, TellThePresentStateOfAnOutput) {
    OutputStatus& status = report_.outputs[0].status;
    const auto state_of = [&](OutputStage stage, bool sends) {
        status.state.stage = stage;
        status.sends = sends;
        return ones("tribus_output_state", "state");
    };
    EXPECT_EQ(state_of(OutputStage::control, true), Words{"control"});
    EXPECT_EQ(state_of(OutputStage::holding, true), Words{"hold"});
    EXPECT_EQ(state_of(OutputStage::failsafe, true), Words{"failsafe"});
    EXPECT_EQ(state_of(OutputStage::failsafe, false), Words{"silent"});
    EXPECT_EQ(state_of(OutputStage::cannot_send, true), Words{"cannot_send"});
}

TEST_F(Metrics, TellTheStateOfACanInterfaceAndWhenItIsGone) {
    EXPECT_TRUE(tells(R"(tribus_can_state{daemon="car",port="can0",state="gone"} 1)"))
        << metrics_text(report_);
    EXPECT_TRUE(tells(R"(tribus_can_state{daemon="car",port="can0",state="ready"} 0)"));
    EXPECT_TRUE(tells(R"(tribus_can_ready{daemon="car",port="can0"} 0)"));
    EXPECT_TRUE(tells(R"(tribus_can_state{daemon="car",port="can1",state="bus_off"} 1)"));
    EXPECT_TRUE(tells(R"(tribus_can_bus_offs_total{daemon="car",port="can1"} 2)"));
    EXPECT_EQ(ones("tribus_can_state", "state"), (Words{"gone", "bus_off"}));
}

/// A value without a fresh number has no sample, because the last one would be stale. Its age goes
/// on.
TEST_F(Metrics, LeaveOutValuesThatAreStale) {
    const std::string number = R"(tribus_value{daemon="car",name="pack.voltage",unit="V"} 12.5)";
    const std::string age =
        R"(tribus_value_age_seconds{daemon="car",name="pack.voltage",unit="V"} )";
    EXPECT_TRUE(tells(number));
    EXPECT_TRUE(tells(age + "0"));
    const std::string text = metrics_text(report_);
    EXPECT_EQ(text.find("tribus_value{"), text.rfind("tribus_value{"));
    EXPECT_EQ(text.find("tribus_value_age_seconds{"), text.rfind("tribus_value_age_seconds{"));
    report_.values[0].value.lasts = std::chrono::seconds(1);
    report_.values[0].status.at = report_.now - std::chrono::seconds(3);
    EXPECT_FALSE(tells(number));
    EXPECT_TRUE(tells(age + "3"));
    report_.values[0].status.available = false;
    EXPECT_TRUE(tells(age + "3"));
}

/// Zero would say that an output that sends nothing is on time.
TEST_F(Metrics, NoFramesHaveNoQuantile) {
    const std::string worst =
        R"(tribus_output_lateness_seconds{daemon="car",output="servos",quantile="1"} )";
    EXPECT_TRUE(tells(worst + "NaN")) << metrics_text(report_);
    report_.outputs[0].lateness.counts[histogram_bucket(std::chrono::milliseconds(2))] = 1;
    report_.outputs[0].lateness.worst = std::chrono::milliseconds(2);
    EXPECT_TRUE(tells(worst + "0.002")) << metrics_text(report_);
}

TEST_F(Metrics, AnotherStartIsAnotherNumber) {
    EXPECT_TRUE(tells(R"(tribus_start_since_boot_seconds{daemon="car"} 90)"));
    report_.now += std::chrono::seconds(5);
    EXPECT_TRUE(tells(R"(tribus_start_since_boot_seconds{daemon="car"} 90)"));
}

TEST_F(Metrics, CountThePartsOfRealTimeThatAreMissing) {
    EXPECT_TRUE(tells(R"(tribus_realtime_parts_missing{daemon="car"} 0)"));
    report_.missing_realtime = {"no SCHED_FIFO", "memory is not locked"};
    EXPECT_TRUE(tells(R"(tribus_realtime_parts_missing{daemon="car"} 2)"));
}

/// Grammar of prometheus.io/docs/instrumenting/exposition_formats, text format 0.0.4.
TEST_F(Metrics, KeepToTheGrammar) {
    const std::regex help("# HELP ([a-zA-Z_:][a-zA-Z0-9_:]*) .+");
    const std::regex type("# TYPE ([a-zA-Z_:][a-zA-Z0-9_:]*) (counter|gauge|summary)");
    const std::regex sample(
        "([a-zA-Z_:][a-zA-Z0-9_:]*)"
        "(\\{[a-zA-Z_][a-zA-Z0-9_]*=\"([^\"\\\\]|\\\\[\\\\n\"])*\""
        "(,[a-zA-Z_][a-zA-Z0-9_]*=\"([^\"\\\\]|\\\\[\\\\n\"])*\")*\\})?"
        " (NaN|[+-]?Inf|[+-]?[0-9.]+(e[+-]?[0-9]+)?)");
    std::set<std::string> families;
    std::string family;
    std::string kind;
    std::istringstream text(metrics_text(report_));
    for (std::string line; std::getline(text, line);) {
        std::smatch match;
        if (std::regex_match(line, match, help)) {
            EXPECT_TRUE(families.insert(match[1]).second) << "twice: " << line;
            family = match[1];
        } else if (std::regex_match(line, match, type)) {
            EXPECT_EQ(match[1], family);
            kind = match[2];
            EXPECT_EQ(family.ends_with("_total"), kind == "counter") << line;
        } else {
            ASSERT_TRUE(std::regex_match(line, match, sample)) << line;
            EXPECT_EQ(match[1], family) << line;
        }
    }
    EXPECT_GT(families.size(), 20U);
}

}  // namespace
}  // namespace tribus::metrics_test
