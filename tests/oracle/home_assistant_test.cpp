#include <fstream>
#include <regex>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/mqtt/discovery.h"
#include "app/mqtt/report.h"
#include "tests/support/shell.h"

/// The template engine that Home Assistant uses (Debian: python3-jinja2) renders our messages, and
/// ids are as its documentation of MQTT discovery allows.
namespace tribus::test::home_assistant_test {
namespace {

using nlohmann::json;

// Names of methods of Python's dict, and signs of templates and of strings in them.
const std::vector<std::string> kNames{
    "receiver", "values", "items",   "keys", "get",   "a",     "a_cause", "pack.voltage",
    "it's",     "a\\",    "{{ 7 }}", "%}",   "\"b\"", "fähre", "a b",     "__class__"};

json status() {
    json told{{"name", "servos"}, {"figures_age_us", 0},      {"unix_time_us", 0},
              {"inputs", {}},     {"outputs", json::array()}, {"values", json::array()}};
    double number = 0;
    for (const std::string& name : kNames) {
        told["inputs"].push_back({{"name", name}, {"cause", "good"}, {"state", "good"}});
        told["outputs"].push_back({{"name", name}, {"state", "control"}});
        told["values"].push_back({{"name", name},
                                  {"unit", "V"},
                                  {"age_us", 7},
                                  {"stale", false},
                                  {"number", number += 0.5}});
    }
    return told;
}

class HomeAssistant : public testing::Test {
  protected:
    void SetUp() override {
        if (run_in_shell("/usr/bin/python3 -c 'import jinja2'").status != 0) {
            GTEST_SKIP() << "needs python3-jinja2";
        }
    }
    static json discovery(const std::string& board) {
        return json::parse(mqtt::discovery_payload(mqtt::topics_of("tribus", board, "servos"),
                                                   board, status(), "0.2.0"));
    }
    /// The rendered texts of that fact of each part of a kind, in the order of the names.
    static std::vector<std::string> rendered(const std::string& kind, const std::string& fact) {
        const TemporaryFolder folder;
        const json message = discovery("pi.lan");
        std::ofstream(folder.path() / "messages") << message.dump() << '\n'
                                                  << mqtt::status_payload(status()) << '\n';
        const Ended ended = run_in_shell("/usr/bin/python3 '" TRIBUS_SOURCE_DIR
                                         "/tests/oracle/render_templates.py' " +
                                         (folder.path() / "messages").string());
        EXPECT_EQ(ended.status, 0) << ended.output;
        const json texts = json::parse(ended.output, nullptr, false);
        std::vector<std::string> all;
        for (const std::string& name : kNames) {
            for (const auto& [id, component] : message["components"].items()) {
                const bool of_kind = id.find("--" + kind + "--") != std::string::npos;
                if (of_kind &&
                    component["name"] == (fact.empty() ? name : kind + " " + name + " " + fact)) {
                    all.push_back(texts.value(id, "not rendered"));
                }
            }
        }
        return all;
    }
};

TEST_F(HomeAssistant, FindsTheNumberOfEachValue) {
    const json told = status();
    std::vector<std::string> numbers;
    for (const json& value : told["values"]) {
        numbers.push_back(value["number"].dump());
    }
    EXPECT_EQ(rendered("value", ""), numbers);
}

TEST_F(HomeAssistant, FindsTheStateOfEachInputAndOutput) {
    EXPECT_EQ(rendered("input", "good"), std::vector<std::string>(kNames.size(), "ON"));
    EXPECT_EQ(rendered("output", "state"), std::vector<std::string>(kNames.size(), "control"));
}

TEST_F(HomeAssistant, TakesTheIdsOfDevicesAndComponents) {
    // Home Assistant, MQTT discovery: ids have characters of [a-zA-Z0-9_-] only.
    const std::regex id("[a-zA-Z0-9_-]+");
    for (const std::string board : {"pi.lan", "my boat", "fähre", "a/b+c#", "$SYS"}) {
        const std::string topic = mqtt::discovery_topic("homeassistant", board, "my boat");
        EXPECT_TRUE(
            std::regex_match(topic, std::regex("homeassistant/device/[a-zA-Z0-9_-]+/config")))
            << topic;
        for (const auto& [key, component] : discovery(board)["components"].items()) {
            EXPECT_TRUE(std::regex_match(key, id)) << key;
        }
    }
}

}  // namespace
}  // namespace tribus::test::home_assistant_test
