#include "app/client/change_reader.h"

#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

/// Statuses and answers as docs/status.md describes them.
namespace tribus::test::change_reader_test {
namespace {

using nlohmann::json;

/// A status of 100 s on the board's clock.
json status(std::uint64_t changes, std::int64_t uptime_us = 5'000'000) {
    return {
        {"type", "status"}, {"changes", changes}, {"t_us", 100'000'000}, {"uptime_us", uptime_us}};
}
json answer(std::uint64_t newest, std::vector<std::uint64_t> numbers, std::uint64_t lost = 0) {
    json changes = json::array();
    for (const std::uint64_t number : numbers) {
        changes.push_back({{"type", "change"}, {"number", number}});
    }
    return {{"type", "changes"}, {"newest", newest}, {"lost", lost}, {"changes", changes}};
}
std::vector<std::uint64_t> numbers(const ChangeReader::News& news) {
    std::vector<std::uint64_t> all;
    for (const json& change : news.changes) {
        all.push_back(change["number"]);
    }
    return all;
}
using Numbers = std::vector<std::uint64_t>;
using Request = std::optional<std::string>;

TEST(ChangeReader, AsksNothingAtTheFirstStatusAndWhileNothingChanges) {
    ChangeReader reader;
    EXPECT_EQ(reader.take_status(status(40)), Request());
    EXPECT_EQ(reader.take_status(status(40)), Request());
}

TEST(ChangeReader, ReadsEachChangeOnce) {
    ChangeReader reader;
    reader.take_status(status(40));
    EXPECT_EQ(reader.take_status(status(42)), Request("changes 40"));
    EXPECT_EQ(reader.take_status(status(43)), Request()) << "one request is on its way";
    const auto news = reader.take_answer(answer(43, {41, 42, 43}));
    EXPECT_EQ(numbers(news), (Numbers{41, 42, 43}));
    EXPECT_EQ(news.request, Request());
    EXPECT_EQ(reader.take_status(status(43)), Request());
    EXPECT_TRUE(reader.take_answer(answer(43, {41, 42, 43})).changes.empty()) << "nobody asked";
}

TEST(ChangeReader, AsksOnWhileAnAnswerHasNotAll) {
    ChangeReader reader;
    reader.take_status(status(0));
    reader.take_status(status(3));
    const auto news = reader.take_answer(answer(3, {1, 2}));
    EXPECT_EQ(news.request, Request("changes 2"));
    EXPECT_EQ(numbers(reader.take_answer(answer(3, {3}))), (Numbers{3}));
}

TEST(ChangeReader, CountsChangesThatItCameTooLateFor) {
    ChangeReader reader;
    reader.take_status(status(10));
    reader.take_status(status(2000));
    const auto news = reader.take_answer(answer(2000, {977, 978}, 966));
    EXPECT_EQ(news.lost, 966U);
    EXPECT_EQ(numbers(news), (Numbers{977, 978}));
    EXPECT_EQ(news.request, Request("changes 978"));
}

TEST(ChangeReader, GoesOnWhereItWasAfterALostConnection) {
    ChangeReader reader;
    reader.take_status(status(5));
    EXPECT_EQ(reader.take_status(status(6)), Request("changes 5"));
    reader.disconnected();
    EXPECT_EQ(reader.take_status(status(9)), Request("changes 5"));
}

TEST(ChangeReader, BeginsAnewWithAnotherProcess) {
    ChangeReader reader;
    reader.take_status(status(5, 60'000'000));
    EXPECT_EQ(reader.take_status(status(7, 100'000)), Request("changes 0"));
    EXPECT_EQ(numbers(reader.take_answer(answer(7, {1, 2, 3, 4, 5, 6, 7}))).size(), 7U);
}

/// The first status of the new process may be later in its life than the last one of the old.
TEST(ChangeReader, KnowsAnotherProcessAlsoIfThatHasRunLonger) {
    ChangeReader reader;
    reader.take_status(status(2, 200'000));
    EXPECT_EQ(reader.take_status(status(2, 390'000)), Request("changes 0"));
    json later = status(2, 590'000);
    later["t_us"] = 100'200'000;
    reader.take_answer(answer(2, {1, 2}));
    EXPECT_EQ(reader.take_status(later), Request()) << "the same process";
}

TEST(ChangeReader, AsksADaemonOfAnEarlierVersionNothing) {
    ChangeReader reader;
    EXPECT_EQ(reader.take_status({{"type", "status"}}), Request());
    EXPECT_TRUE(reader.take_answer(answer(3, {1})).changes.empty());
}

TEST(ChangeReader, TakesNothingOfAnAnswerThatIsNone) {
    ChangeReader reader;
    reader.take_status(status(0));
    reader.take_status(status(3));
    for (const char* text : {"null", "7", R"({"changes":[5,{"number":9}],"newest":"x"})"}) {
        EXPECT_TRUE(reader.take_answer(json::parse(text)).changes.empty()) << text;
        reader.take_status(status(3));
    }
}

}  // namespace
}  // namespace tribus::test::change_reader_test
