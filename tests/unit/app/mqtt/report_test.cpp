#include "app/mqtt/report.h"

#include <chrono>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

/// Statuses and events as they are told over MQTT, from statuses as docs/status.md describes them.
namespace tribus::mqtt::report_test {
namespace {

using namespace std::chrono_literals;
using Lines = std::vector<std::string>;

// 2026-11-26 20:45:13.250 UTC.
constexpr std::int64_t kUnixTime = 1'795'725'913'250'000;
constexpr Instant kNow{100s};

Json status() {
    return Json::parse(R"({"type":"status","version":1,"name":"servos","t_us":50000000,
        "unix_time_us":1795725913250000,"uptime_us":60000000,"figures_age_us":40000,
        "fingerprint":"f00d","trial":null,"trial_left_us":null,
        "inputs":[{"name":"receiver","state":"good","cause":"good","state_age_us":5000000,
                   "rate_hz":130,"age_us":3000}],
        "outputs":[{"name":"servos","state":"control","state_age_us":2000000,
                    "input":"receiver","obstacle":null,
                    "rate_hz":71.5}],
        "ports":[{"name":"/dev/ttyAMA0","kind":"serial","present":true},
                 {"name":"can0","kind":"can","present":true,"can":{"state":"ready"}}],
        "values":[{"name":"pack.voltage","number":12.25,"unit":"V","age_us":200000,
                   "stale":false}]})");
}

TEST(MqttStatus, HasStatesCausesAndValuesWithTheirAges) {
    const Json told = Json::parse(status_payload(status()));
    EXPECT_EQ(told["time"], "2026-11-26T20:45:13.250Z");
    EXPECT_EQ(told["unix_time_us"], kUnixTime);
    EXPECT_EQ(told["figures_age_s"], 0.04);
    EXPECT_EQ(told["inputs"]["receiver"], Json::parse(R"({"good":true,"cause":"good","for_s":5.0,
        "rate_hz":130.0,"age_s":0.003})"));
    EXPECT_EQ(told["outputs"]["servos"], Json::parse(R"({"state":"control","input":"receiver",
        "obstacle":null,"for_s":2.0,"waits_for":null,"rate_hz":71.5})"));
    EXPECT_EQ(told["devices"]["can0"], Json::parse(R"({"present":true,"bus":"ready"})"));
    EXPECT_EQ(told["values"]["pack.voltage"],
              Json::parse(R"({"number":12.25,"unit":"V","age_s":0.2})"));
}

TEST(MqttStatus, SaysWhatAnOutputWaitsFor) {
    Json waiting = status();
    waiting["outputs"][0]["state"] = "failsafe";
    waiting["outputs"][0]["input"] = nullptr;
    waiting["outputs"][0]["waits_for"] = "receiver: good for 0.2 of 0.5 s";
    EXPECT_EQ(Json::parse(status_payload(waiting))["outputs"]["servos"],
              Json::parse(R"({"state":"failsafe","input":null,"obstacle":null,
        "for_s":2.0,"waits_for":"receiver: good for 0.2 of 0.5 s","rate_hz":71.5})"));
}

TEST(MqttStatus, HasNoNumberOfAValueThatIsStale) {
    Json old = status();
    old["values"][0]["stale"] = true;
    const Json told = Json::parse(status_payload(old));
    EXPECT_TRUE(told["values"]["pack.voltage"]["number"].is_null());
}

TEST(MqttStatus, HasNoValuesThatNeverCameOrThatAreOfInputsAndOutputs) {
    Json more = status();
    more["values"].push_back({{"name", "pack.cells.1"}, {"age_us", nullptr}, {"stale", true}});
    more["values"].push_back({{"name", "input.receiver.age"}, {"number", 5}, {"age_us", 1}});
    EXPECT_EQ(Json::parse(status_payload(more))["values"].size(), 1U);
}

TEST(MqttStatus, TellsNothingOfFiguresThatAreOlderThanASecond) {
    Json old = status();
    old["figures_age_us"] = 1'000'000;
    EXPECT_FALSE(Json::parse(status_payload(old))["inputs"].empty());
    old["figures_age_us"] = 1'000'001;
    const Json told = Json::parse(status_payload(old));
    for (const char* part : {"inputs", "outputs", "devices", "values"}) {
        EXPECT_TRUE(told[part].empty()) << part;
    }
    EXPECT_EQ(told["figures_age_s"], 1.0);
    EXPECT_FALSE(has_new_figures(Json::parse("{}")));
}

TEST(MqttStatus, IsMadeOfAnyObject) {
    for (const char* text : {"{}", R"({"inputs":7,"outputs":[3],"values":[{"name":5}],"ports":{}})",
                             R"({"figures_age_us":0,"inputs":[{"name":null}]})",
                             R"({"figures_age_us":-1e300,"unix_time_us":1e300})"}) {
        EXPECT_TRUE(Json::parse(status_payload(Json::parse(text))).is_object()) << text;
        EXPECT_FALSE(event_of(Json::parse(text), status(), kNow)) << text;
    }
}

/// As docs/status.md describes it.
Json change() {
    return Json::parse(R"json({"type":"change","number":7,"t_us":49850000,
        "unix_time_us":1795725913100000,"part":"input","name":"receiver","field":"cause",
        "was":"good","now":"wire_silent",
        "text":"input receiver: wire silent (no bytes any more)"})json");
}

TEST(MqttEvents, AreTheChangesOfTheDaemonWithItsTimeAndItsWords) {
    const auto event = event_of(change(), status(), kNow);
    ASSERT_TRUE(event);
    EXPECT_EQ(event->type, "input");
    EXPECT_EQ(event->name, "receiver");
    EXPECT_EQ(event->now, "wire_silent");
    EXPECT_EQ(event->before, "good");
    EXPECT_EQ(event->text, "input receiver: wire silent (no bytes any more)");
    EXPECT_EQ(event->unix_time_us, kUnixTime - 150'000);
    EXPECT_EQ(event->at, kNow - 150ms);
}

TEST(MqttEvents, AreOfEveryPartThatTheDaemonTells) {
    for (const char* part :
         {"input", "output", "device", "bus", "node", "value", "configuration", "daemon"}) {
        Json of_part = change();
        of_part["part"] = part;
        of_part["field"] = "state";
        EXPECT_EQ(event_of(of_part, status(), kNow)->type, part);
    }
    Json unknown = change();
    unknown["part"] = "else";
    EXPECT_FALSE(event_of(unknown, status(), kNow));
}

TEST(MqttEvents, TellThatAnotherInputHasTakenOver) {
    Json over = change();
    over["part"] = "output";
    over["field"] = "input";
    over["was"] = "receiver";
    over["now"] = "backup";
    const auto event = event_of(over, status(), kNow);
    EXPECT_EQ(event->now, "control");
    EXPECT_EQ(event->before, "control");
}

TEST(MqttEvents, HaveNoDetailsOfAState) {
    for (const char* field : {"waits_for", "text"}) {
        Json detail = change();
        detail["part"] = "output";
        detail["field"] = field;
        EXPECT_FALSE(event_of(detail, status(), kNow)) << field;
    }
}

TEST(MqttEvents, CarryTheirTimeTheirAgeAndWhetherTheyAreLate) {
    const Event event{.type = "input",
                      .name = "receiver",
                      .now = "wire_silent",
                      .before = "good",
                      .text = "input receiver: wire silent",
                      .unix_time_us = kUnixTime,
                      .at = kNow};
    const Json told = Json::parse(event_payload(event, "s-7", true, 3, kNow + 12'345ms));
    EXPECT_EQ(told, Json::parse(R"({"event_type":"input","id":"s-7","name":"receiver",
        "now":"wire_silent","before":"good","text":"input receiver: wire silent",
        "time":"2026-11-26T20:45:13.250Z","unix_time_us":1795725913250000,"age_s":12.345,
        "late":true,"lost_before":3})"));
    EXPECT_FALSE(Json::parse(event_payload(event, "s-7", false, 0, kNow)).contains("lost_before"));
}

TEST(MqttTopics, HaveNoCharactersWithAMeaning) {
    EXPECT_EQ(topic_level("boat-1.local"), "boat-1.local");
    EXPECT_EQ(topic_level("my_boat"), "my_boat");
    EXPECT_EQ(topic_level("a/b+c#d e"), "a%2Fb%2Bc%23d%20e");
    EXPECT_EQ(topic_level("$SYS"), "%24SYS");
    EXPECT_EQ(topic_level("fähre"), "f%C3%A4hre");
}

TEST(MqttTopics, AreOthersForOtherNames) {
    std::set<std::string> levels;
    const Lines names{"",    "%",     "a b", "a#b",      "a+b",  "a/b", "a_b",
                      "a-b", "a%20b", "a%b", "\xC3\xA4", "\xE4", "A_b", "%2520"};
    for (const std::string& name : names) {
        levels.insert(topic_level(name));
    }
    EXPECT_EQ(levels.size(), names.size());
}

TEST(MqttTopics, BeginWithPlainLevels) {
    for (const char* const right : {"tribus", "home/boats", "a.b-c_d", "%41"}) {
        EXPECT_TRUE(may_begin_topics(right)) << right;
    }
    for (const char* const wrong : {"", "a/#", "#", "+", "a/+/b", "a+", "/a", "a/", "a//b", "$SYS",
                                    "$share/a", "a b", "a\n", "a\x7F", "b\xC3\xA4r"}) {
        EXPECT_FALSE(may_begin_topics(wrong)) << wrong;
    }
    EXPECT_TRUE(may_begin_topics(std::string(64, 'a')));
    EXPECT_FALSE(may_begin_topics(std::string(65, 'a')));
}

}  // namespace
}  // namespace tribus::mqtt::report_test
