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
        report_.inputs[0].reject_causes = {"checksum"};
        report_.inputs[0].status.rejected_by = {3};
        report_.outputs.resize(1);
        report_.ports = {{"/dev/tty\"A\\2\n", true, {}},
                         {"can0", false, CanLinkStatus{CanBusState::bus_off, {}}}};
        const NamedValue value{.name = "pack.voltage", .unit = "V", .lasts = kForever};
        report_.values = {
            {value, {.number = 12.5, .at = report_.now, .ever = true, .available = true}},
            {value, {}}};
    }
    bool tells(const std::string& line) const {
        return ("\n" + metrics_text(report_)).find("\n" + line + "\n") != std::string::npos;
    }

    Configuration configuration_;
    StatusReport report_;
};

TEST_F(Metrics, CountByName) {
    EXPECT_TRUE(tells("tribus_input_frames_total{daemon=\"car\",input=\"main\"} 42"))
        << metrics_text(report_);
    EXPECT_TRUE(
        tells("tribus_input_rejected_total{daemon=\"car\",input=\"main\",cause=\"checksum\"} 3"));
    EXPECT_TRUE(tells("tribus_output_in_control{daemon=\"car\",output=\"servos\"} 0"));
    EXPECT_TRUE(tells("tribus_figures_age_seconds{daemon=\"car\"} 0.05"));
}

TEST_F(Metrics, EscapeWhatStandsInLabels) {
    EXPECT_TRUE(tells(R"(tribus_port_present{daemon="car",port="/dev/tty\"A\\2\n"} 1)"))
        << metrics_text(report_);
}

/// A value without a fresh number has no sample, because the last one would be stale.
TEST_F(Metrics, LeaveOutValuesThatAreStale) {
    EXPECT_TRUE(tells("tribus_value{daemon=\"car\",name=\"pack.voltage\",unit=\"V\"} 12.5"));
    const std::string text = metrics_text(report_);
    EXPECT_EQ(text.find("tribus_value{"), text.rfind("tribus_value{"));
}

/// Grammar of prometheus.io/docs/instrumenting/exposition_formats, text format 0.0.4.
TEST_F(Metrics, KeepToTheGrammar) {
    const std::regex help("# HELP ([a-zA-Z_:][a-zA-Z0-9_:]*) .+");
    const std::regex type("# TYPE ([a-zA-Z_:][a-zA-Z0-9_:]*) (counter|gauge)");
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
