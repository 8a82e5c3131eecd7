#include "tests/bench/codec_counts.h"

#include <algorithm>
#include <cstdlib>
#include <ostream>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

#include "tests/bench/daemon_counts.h"

namespace tribus::bench::codec_counts_test {

/// Name of a row in googletest's output.
void PrintTo(const Row& row, std::ostream* out) {
    *out << row.name;
}

namespace {

bool on_ci() {
    const char* ci = std::getenv("CI");
    return ci != nullptr && std::string_view(ci) == "true";
}

class CodecCounts : public testing::TestWithParam<Row> {
  protected:
    /// Returns whether the machine can count. On the build server no count may be skipped.
    static bool ready(Machine machine) {
        const std::string what = missing(machine);
        if (!what.empty() && on_ci()) {
            ADD_FAILURE() << what;
        }
        return what.empty();
    }
};

TEST_P(CodecCounts, StaysBelowItsCeilingOnX86) {
    if (!ready(Machine::x86)) {
        GTEST_SKIP() << missing(Machine::x86);
    }
    const auto measured = cost(Machine::x86, GetParam());
    ASSERT_TRUE(measured) << "the counting run failed";
    RecordProperty("instructions", std::to_string(*measured));
    EXPECT_LE(*measured, GetParam().most_x86);
}

TEST_P(CodecCounts, StaysBelowItsCeilingOnArm) {
    if (!ready(Machine::arm)) {
        GTEST_SKIP() << missing(Machine::arm);
    }
    const auto measured = cost(Machine::arm, GetParam());
    ASSERT_TRUE(measured) << "the counting run failed";
    RecordProperty("instructions", std::to_string(*measured));
    EXPECT_LE(*measured, GetParam().most_arm);
}

INSTANTIATE_TEST_SUITE_P(Frames, CodecCounts, testing::ValuesIn(kFrameRows),
                         [](const auto& row) { return std::string(row.param.name); });

/// Whether the product was compiled as for a release, without sanitizers.
constexpr bool kCountsTheBuild = TRIBUS_COUNTS_THE_BUILD != 0;

class EngineCounts : public CodecCounts {};

TEST_P(EngineCounts, StayBelowTheirCeiling) {
    if (!kCountsTheBuild || !ready(Machine::x86)) {
        GTEST_SKIP() << "needs a release build and valgrind";
    }
    const auto measured = cost(Machine::x86, GetParam());
    ASSERT_TRUE(measured) << "the counting run failed";
    RecordProperty("instructions", std::to_string(*measured));
    EXPECT_LE(*measured, GetParam().most_x86);
}

INSTANTIATE_TEST_SUITE_P(Frames, EngineCounts, testing::ValuesIn(kEngineRows),
                         [](const auto& row) { return std::string(row.param.name); });

TEST(DaemonCounts, StayBelowTheirCeiling) {
    if (!kCountsTheBuild || !missing(Machine::x86).empty()) {
        GTEST_SKIP() << "needs a release build and valgrind";
    }
    // Other work on the machine only adds wake-ups, so the least of some runs counts.
    constexpr int kRuns = 3;
    double least = 0;
    for (int run = 0; run < kRuns && (run == 0 || least > kMostOfDaemon); ++run) {
        const auto measured = instructions_a_frame();
        ASSERT_TRUE(measured) << measured.error();
        least = run == 0 ? *measured : std::min(least, *measured);
    }
    RecordProperty("instructions", std::to_string(least));
    EXPECT_LE(least, kMostOfDaemon);
}

class GarbageCounts : public CodecCounts {};

TEST_P(GarbageCounts, AreLinear) {
    if (!ready(Machine::x86)) {
        GTEST_SKIP() << missing(Machine::x86);
    }
    const auto first = cost(Machine::x86, GetParam(), 256, 512, 1024);
    const auto twice = cost(Machine::x86, GetParam(), 512, 1024, 1024);
    ASSERT_TRUE(first && twice) << "the counting run failed";
    // Random bytes differ from block to block, which shows where they cost little.
    EXPECT_NEAR(*twice, *first, std::max(0.05 * *first, 1.0));
}

INSTANTIATE_TEST_SUITE_P(Garbage, GarbageCounts, testing::ValuesIn(kGarbageRows),
                         [](const auto& row) { return std::string(row.param.name); });
INSTANTIATE_TEST_SUITE_P(Garbage, CodecCounts, testing::ValuesIn(kGarbageRows),
                         [](const auto& row) { return std::string(row.param.name); });

}  // namespace
}  // namespace tribus::bench::codec_counts_test
