#include "app/changes/change_json.h"

#include <array>
#include <chrono>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace tribus::test::change_json_test {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;

ToldChange hold() {
    return {.at = Instant(5s),
            .wall_time = 1'795'727'363'611'999us,
            .part = "output",
            .name = "servos",
            .field = "state",
            .was = "control",
            .now = "hold",
            .text = "holding the last values, marked frame-lost",
            .state = "hold",
            .kind = "output"};
}
json answer(const ChangeJournal& changes, const std::string& since) {
    return json::parse(changes_json(changes, std::array{since}));
}

TEST(ChangesAnswer, HasEachChangeWithItsSentence) {
    ChangeJournal changes;
    changes.add(hold());
    EXPECT_EQ(changes_json(changes, {}),
              R"({"type":"changes","newest":1,"lost":0,"changes":[{"type":"change","number":1,)"
              R"("t_us":5000000,"unix_time_us":1795727363611999,"part":"output","name":"servos",)"
              R"("field":"state","was":"control","now":"hold",)"
              R"("text":"output servos: holding the last values, marked frame-lost",)"
              R"("input":null}]})");
}

TEST(ChangesAnswer, BeginsBehindTheNumberThatTheReaderHas) {
    ChangeJournal changes;
    for (int i = 0; i < 3; ++i) {
        changes.add(hold());
    }
    EXPECT_EQ(answer(changes, "1")["changes"].size(), 2U);
    EXPECT_EQ(answer(changes, "1")["changes"][0]["number"], 2);
    EXPECT_EQ(answer(changes, "3")["changes"].size(), 0U);
}

/// An answer fits into the memory that a client may hold.
TEST(ChangesAnswer, HasAtMostAHundredAndSaysThatThereAreMore) {
    ChangeJournal changes;
    for (int i = 0; i < 250; ++i) {
        changes.add(hold());
    }
    const json first = answer(changes, "0");
    EXPECT_EQ(first["changes"].size(), 100U);
    EXPECT_EQ(first["newest"], 250);
    EXPECT_EQ(answer(changes, "200")["changes"].size(), 50U);
}

TEST(ChangesAnswer, SaysHowManyAreNoLongerKept) {
    ChangeJournal changes;
    for (std::size_t i = 0; i < ChangeJournal::kChanges + 5; ++i) {
        changes.add(hold());
    }
    EXPECT_EQ(answer(changes, "0")["lost"], 5);
    EXPECT_EQ(answer(changes, "0")["changes"][0]["number"], 6);
    EXPECT_EQ(answer(changes, "3")["lost"], 2);
    EXPECT_EQ(answer(changes, "5")["lost"], 0);
}

TEST(ChangesAnswer, RefusesWhatIsNoNumberThatThereWas) {
    ChangeJournal changes;
    changes.add(hold());
    for (const char* words : {"2", "-1", "x", "1x", "", "99999999999999999999"}) {
        EXPECT_EQ(answer(changes, words)["type"], "error") << words;
    }
    EXPECT_EQ(json::parse(changes_json(changes, std::array<std::string, 2>{"1", "1"}))["type"],
              "error");
}

}  // namespace
}  // namespace tribus::test::change_json_test
