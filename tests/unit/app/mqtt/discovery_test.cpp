#include "app/mqtt/discovery.h"

#include <set>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/mqtt/broker_place.h"

/// Discovery by Home Assistant, and places of brokers.
namespace tribus::mqtt::discovery_test {
namespace {

using nlohmann::json;

const DaemonTopics kTopics = topics_of("tribus", "boat 1", "servos");

json discovered() {
    return json::parse(discovery_payload(kTopics, "boat 1", json::parse(R"({"name":"servos",
        "inputs":[{"name":"receiver"}],"outputs":[{"name":"servos"}],
        "ports":[{"name":"can0","can":{}}],
        "values":[{"name":"pack.voltage","unit":"V","age_us":7},
                  {"name":"it's","unit":"","age_us":7},
                  {"name":"pack.cells.1","unit":"V","age_us":null},
                  {"name":"input.receiver.age","unit":"ms","age_us":7}]})"),
                                         "0.2.0"));
}

TEST(MqttTopics, AreBelowTheBoardAndTheDaemon) {
    EXPECT_EQ(kTopics.board_availability, "tribus/boat%201/availability");
    EXPECT_EQ(kTopics.availability, "tribus/boat%201/servos/availability");
    EXPECT_EQ(kTopics.status, "tribus/boat%201/servos/status");
    EXPECT_EQ(kTopics.event, "tribus/boat%201/servos/event");
    EXPECT_EQ(discovery_topic("homeassistant", "boat 1", "servos"),
              "homeassistant/device/tribus--boat-201--servos/config");
}

TEST(Discovery, MakesADeviceWithInputsOutputsCausesValuesAndEvents) {
    const json told = discovered();
    EXPECT_EQ(told["device"]["name"], "servos on boat 1");
    std::set<std::string> ids;
    for (const auto& [id, component] : told["components"].items()) {
        EXPECT_EQ(component["unique_id"], id);
        ids.insert(id);
    }
    EXPECT_EQ(ids,
              (std::set<std::string>{"tribus--boat-201--servos--event",
                                     "tribus--boat-201--servos--input--receiver--good",
                                     "tribus--boat-201--servos--input--receiver--cause",
                                     "tribus--boat-201--servos--output--servos--state",
                                     "tribus--boat-201--servos--port--can0--bus",
                                     "tribus--boat-201--servos--port--can0--present",
                                     "tribus--boat-201--servos--value--it-27s--number",
                                     "tribus--boat-201--servos--value--pack-2Evoltage--number"}));
}

TEST(Discovery, HasOtherIdsForOtherNames) {
    const auto ids = [](const std::string& board, const std::string& daemon, const json& names) {
        json status{{"name", daemon}, {"inputs", json::array()}};
        for (const auto& name : names) {
            status["inputs"].push_back({{"name", name}});
        }
        const DaemonTopics topics = topics_of("tribus", board, daemon);
        const json told = json::parse(discovery_payload(topics, board, status, "0.2.0"));
        std::set<std::string> all;
        for (const auto& [id, component] : told["components"].items()) {
            all.insert(id);
        }
        return all;
    };
    EXPECT_EQ(ids("b", "d", {"a", "a_cause", "a b", "a-20b", "a.b", "a#b", "cause"}).size(),
              7U * 2U + 1U);
    std::set<std::string> together = ids("b", "d_input", {"a"});
    together.merge(ids("b_d", "input", {"a"}));
    together.merge(ids("b-", "d", {"a"}));
    together.merge(ids("b", "-d", {"a"}));
    together.merge(ids("b", "d", {"-a", "a"}));
    EXPECT_EQ(together.size(), 4U * 3U + 5U);
}

TEST(Discovery, ExpiresWhateverIsToldEachSecond) {
    const nlohmann::json components = discovered()["components"];
    for (const auto& [id, component] : components.items()) {
        if (component["platform"] != "event") {
            EXPECT_EQ(component["expire_after"], 5) << id;
            EXPECT_EQ(component["state_topic"], kTopics.status) << id;
        }
    }
}

TEST(Discovery, IsAvailableOnlyWhileBridgeAndDaemonAre) {
    const json told = discovered();
    EXPECT_EQ(told["availability_mode"], "all");
    EXPECT_EQ(told["availability"][0]["topic"], "tribus/boat%201/availability");
    EXPECT_EQ(told["availability"][1]["topic"], "tribus/boat%201/servos/availability");
    EXPECT_EQ(told["availability"].size(), 2U);
}

TEST(Discovery, NamesAllCausesAndStatesThatAStatusCanHave) {
    const json components = discovered()["components"];
    EXPECT_EQ(components["tribus--boat-201--servos--input--receiver--cause"]["options"],
              json::parse(R"(["good","never_seen","wire_silent","garbled","radio_lost","stale",
                              "implausible","channels_missing","no_key","forged","replayed",
                              "late","unproved"])"));
    EXPECT_EQ(components["tribus--boat-201--servos--output--servos--state"]["options"],
              json::parse(R"(["control","hold","failsafe","silent","cannot_send"])"));
}

TEST(Discovery, FindsEachPartOfAStatusByItsName) {
    const json components = discovered()["components"];
    EXPECT_EQ(components["tribus--boat-201--servos--input--receiver--good"]["value_template"],
              "{{ 'ON' if value_json['inputs']['receiver']['good'] else 'OFF' }}");
    EXPECT_EQ(components["tribus--boat-201--servos--value--it-27s--number"]["value_template"],
              R"({{ value_json['values']['it\'s']['number'] }})");
    EXPECT_EQ(components["tribus--boat-201--servos--value--pack-2Evoltage--number"]
                        ["unit_of_measurement"],
              "V");
    EXPECT_FALSE(components["tribus--boat-201--servos--value--it-27s--number"].contains(
        "unit_of_measurement"));
}

TEST(BrokerPlaces, AreNamesAndAddressesWithOrWithoutAPort) {
    const auto host = [](const char* text) { return parse_broker_place(text)->host; };
    const auto port = [](const char* text) { return parse_broker_place(text)->port; };
    EXPECT_EQ(host("broker.local"), "broker.local");
    EXPECT_EQ(port("broker.local"), std::nullopt);
    EXPECT_EQ(host("192.0.2.7:8883"), "192.0.2.7");
    EXPECT_EQ(port("192.0.2.7:8883"), 8883);
    EXPECT_EQ(host("[::1]:1883"), "::1");
    EXPECT_EQ(port("[::1]"), std::nullopt);
    for (const char* wrong : {"", ":1883", "a:", "a:0", "a:65536", "a:1x", "[::1", "[::1]1883",
                              "mqtt://a", "me@a", "a b"}) {
        EXPECT_FALSE(parse_broker_place(wrong)) << wrong;
    }
}

TEST(BrokerPlaces, KnowThoseOfThisMachine) {
    for (const char* own : {"localhost", "127.0.0.1:1883", "127.8.9.10", "[::1]:1883"}) {
        EXPECT_TRUE(parse_broker_place(own)->is_loopback()) << own;
    }
    for (const char* other : {"broker.local", "127.example.org", "127.0.0.1.example.org:1883",
                              "[::2]:1883", "[::127.0.0.1]", "128.0.0.1", "localhost.example"}) {
        EXPECT_FALSE(parse_broker_place(other)->is_loopback()) << other;
    }
}

}  // namespace
}  // namespace tribus::mqtt::discovery_test
