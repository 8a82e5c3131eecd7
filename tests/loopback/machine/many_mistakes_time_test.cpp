#include <chrono>
#include <ctime>
#include <string>

#include <gtest/gtest.h>

#include "config/load.h"
#include "tests/support/seen_within.h"

namespace tribus::test::many_mistakes_time_test {
namespace {

/// A pipeline with so many unknown tables beside it.
std::string with_unknown_tables(int count) {
    std::string text =
        "[input.rx]\nprotocol = \"ibus\"\ndevice = \"/dev/a\"\n"
        "[output.o]\nprotocol = \"sbus\"\ndevice = \"/dev/b\"\n"
        "[pipeline.main]\nfrom = \"rx\"\nto = \"o\"\n";
    for (int table = 0; table < count; ++table) {
        text += "[x" + std::to_string(table) + "]\n";
    }
    return text;
}

/// Processor time of this process for reading the text.
std::chrono::nanoseconds time_to_read(const std::string& text) {
    const auto used = [] {
        timespec time{};
        ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
        return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
    };
    const auto before = used();
    EXPECT_FALSE(load_configuration(text, "c.toml"));
    return used() - before;
}

/// If it grew with their square, ten times as many would take a hundred times as long.
TEST(TimeOfManyMistakes, GrowsAsTheirNumber) {
    const std::string few = with_unknown_tables(20'000);
    const std::string many = with_unknown_tables(200'000);
    // Other work takes caches away, for one of them more than for the other: the best turn counts.
    EXPECT_TRUE(seen_within([&] { return time_to_read(many) < 20 * time_to_read(few); }));
}

}  // namespace
}  // namespace tribus::test::many_mistakes_time_test
