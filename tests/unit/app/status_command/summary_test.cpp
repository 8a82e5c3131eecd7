#include "app/status_command/summary.h"

#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace tribus::summary_test {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;

constexpr std::string_view kStatus = R"({"type":"status","version":1,"name":"car",
"file":"/etc/tribus/car.toml","fingerprint":"00ff","t_us":7000000,"unix_time_us":1795727363411000,
"uptime_us":5000000,"figures_age_us":40000,"trial":null,"trial_left_us":null,
"inputs":[{"name":"main","protocol":"ibus","state":"good","cause":"good","age_us":3000,
"losses":{"wire_silent":2,"garbled":1}},
{"name":"backup","state":"failsafe","cause":"implausible","age_us":null,"losses":{},
"text":"implausible, channel 5 is at 2158 us"
}],
"outputs":[{"name":"servos","state":"control","obstacle":null,"input":"main",
"text":"under control of main","failsafe_entries":3}],
"ports":[{"name":"/dev/ttyUSB0","kind":"serial","present":false},
{"name":"/dev/ttyAMA5","kind":"serial","present":true},
{"name":"can0","kind":"can","present":true,"can":{"state":"bus_off","sent":7}}]
})";

class Summary : public testing::Test {
  protected:
    ordered_json told() const {
        const auto found = status_summary::of_status(status_);
        EXPECT_TRUE(found) << found.error();
        return found.value_or(ordered_json());
    }
    json status_ = json::parse(kStatus);
};

using Lines = std::vector<std::string>;

TEST_F(Summary, TellsWhatAScriptAsksFor) {
    EXPECT_EQ(
        told().dump(),
        R"({"type":"summary","version":1,"name":"car","file":"/etc/tribus/car.toml",)"
        R"("fingerprint":"00ff","t_us":7000000,"unix_time_us":1795727363411000,)"
        R"("uptime_us":5000000,"figures_age_us":40000,"figures_old":false,)"
        R"("trial":null,"trial_left_us":null,)"
        R"("inputs":[{"name":"main","good":true,"cause":"good","text":null,"age_us":3000,)"
        R"("times_lost":3},{"name":"backup","good":false,"cause":"implausible",)"
        R"("text":"implausible, channel 5 is at 2158 us",)"
        R"("age_us":null,"times_lost":0}],)"
        R"("outputs":[{"name":"servos","state":"control","obstacle":null,"input":"main",)"
        R"("text":"under control of main","waits_for":null,"why":null,"failsafe_entries":3}],)"
        R"("devices":[{"name":"/dev/ttyUSB0","state":"gone"},)"
        R"({"name":"/dev/ttyAMA5","state":"there"},{"name":"can0","state":"bus_off"}],)"
        R"("gone":["/dev/ttyUSB0"]})");
}

TEST_F(Summary, InWordsHasALineForEachPart) {
    status_["trial"] = 4U;
    status_["trial_left_us"] = 25'000'000;
    EXPECT_EQ(status_summary::lines(told()),
              (Lines{"car: up 5.00 s, figures 40 ms old, configuration /etc/tribus/car.toml (00ff)",
                     "trial 4: goes back in 25.00 s unless confirmed",
                     "input main: good, newest frame 3.0 ms old",
                     "input backup: implausible, channel 5 is at 2158 us, no frame yet",
                     "output servos: under control of main", "device /dev/ttyUSB0: gone",
                     "device /dev/ttyAMA5: there", "device can0: bus_off"}));
}

TEST_F(Summary, SaysWhatAnOutputWaitsForWhileItsFiguresAreNew) {
    status_["outputs"][0]["state"] = "failsafe";
    status_["outputs"][0]["text"] = "in failsafe";
    status_["outputs"][0]["input"] = nullptr;
    status_["outputs"][0]["waits_for"] = "main: good for 0.2 of 0.5 s";
    const std::string why = "it sends its presets; waits for main: good for 0.2 of 0.5 s";
    status_["outputs"][0]["why"] = why;
    EXPECT_EQ(told()["outputs"][0]["waits_for"], "main: good for 0.2 of 0.5 s");
    EXPECT_EQ(told()["outputs"][0]["why"], why);
    EXPECT_EQ(status_summary::lines(told())[3], "output servos: in failsafe; " + why);
    status_["figures_age_us"] = 1'000'001;
    EXPECT_TRUE(told()["outputs"][0]["waits_for"].is_null());
    EXPECT_TRUE(told()["outputs"][0]["why"].is_null());
}

/// The data thread hangs: its last figures say "good" and "control" for ever.
TEST_F(Summary, OldFiguresClaimNothing) {
    status_["figures_age_us"] = 1'000'001;
    const auto old = told();
    EXPECT_EQ(old["figures_old"], true);
    EXPECT_EQ(old["inputs"][0]["good"], false);
    EXPECT_EQ(old["inputs"][0]["cause"], "unknown");
    EXPECT_EQ(old["outputs"][0]["state"], "unknown");
    EXPECT_TRUE(old["outputs"][0]["input"].is_null());
    EXPECT_EQ(old["devices"][1]["state"], "unknown");
    EXPECT_EQ(old["gone"], ordered_json::array());
    EXPECT_EQ(status_summary::lines(old)[0], "car: STANDS STILL since 1.00 s");
    status_["figures_age_us"] = 1'000'000;
    EXPECT_EQ(told()["figures_old"], false);
    status_.erase("figures_age_us");
    EXPECT_EQ(told()["figures_old"], true) << "without an age nobody knows";
}

TEST_F(Summary, IsMadeOfNothingButAStatus) {
    for (const std::string_view other : {"null", "[]", "{}", R"({"type":"error","error":"x"})"}) {
        EXPECT_FALSE(status_summary::of_status(json::parse(other))) << other;
    }
}

TEST_F(Summary, DoesNotFailForAStatusWithForeignTypes) {
    status_["inputs"] = json::parse(R"([7,null,{"name":{},"cause":1,"losses":"x"}])");
    status_["outputs"] = "x";
    status_["ports"] = json::parse(R"([{"can":{}}])");
    const auto odd = told();
    EXPECT_EQ(odd["inputs"][2]["good"], false);
    EXPECT_EQ(odd["outputs"], ordered_json::array());
    EXPECT_EQ(odd["devices"][0]["state"], "gone");
    EXPECT_EQ(status_summary::lines(odd).size(), 5U);
}

TEST_F(Summary, InWordsHasNoControlCharacters) {
    status_["inputs"][0]["name"] = "\x1b[2Jmain\n";
    EXPECT_EQ(status_summary::lines(told())[1], "input ?[2Jmain?: good, newest frame 3.0 ms old");
}

/// As docs/status.md describes it.
constexpr std::string_view kChange = R"({"type":"change","number":7,"t_us":6850000,
"unix_time_us":1795727363611999,"part":"output","name":"servos","field":"state","was":"control",
"now":"hold","text":"output servos: holding the last values, marked frame-lost","input":null,
"later":"unknown"})";

TEST(SummaryOfAChange, HasFixedFields) {
    EXPECT_EQ(status_summary::of_change(json::parse(kChange)).dump(),
              R"({"type":"change","number":7,"t_us":6850000,"unix_time_us":1795727363611999,)"
              R"("part":"output","name":"servos","field":"state","was":"control","now":"hold",)"
              R"("text":"output servos: holding the last values, marked frame-lost",)"
              R"("input":null})");
}

TEST(SummaryOfAChange, InWordsHasTheTimeTheSentenceAndWhatWasBefore) {
    json change = json::parse(kChange);
    const auto words = [&] { return status_summary::line(status_summary::of_change(change)); };
    EXPECT_EQ(words(),
              "2026-11-26T21:09:23.611Z output servos: holding the last values, marked frame-lost, "
              "was control");
    change["field"] = "waits_for";
    change["text"] = "output servos: waits for main: \x1b[2Jgood";
    EXPECT_EQ(words(), "2026-11-26T21:09:23.611Z output servos: waits for main: ?[2Jgood");
}

TEST_F(Summary, ThatADaemonDoesNotAnswerIsAChangeWithAReason) {
    const auto line_at = [&](std::int64_t unix_time_us, const std::string& why) {
        return status_summary::line(
            status_summary::change_of_daemon(told(), {.field = "answers",
                                                      .now = false,
                                                      .text = "does not answer",
                                                      .why = why,
                                                      .t_us = 5,
                                                      .unix_time_us = unix_time_us}));
    };
    EXPECT_EQ(line_at(1'000'000, "it is gone"),
              "1970-01-01T00:00:01.000Z daemon car: does not answer: it is gone");
    for (const std::int64_t never : {std::int64_t{-1}, std::numeric_limits<std::int64_t>::max()}) {
        EXPECT_EQ(line_at(never, ""), "daemon car: does not answer");
    }
}

}  // namespace
}  // namespace tribus::summary_test
