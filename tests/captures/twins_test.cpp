#include "tests/captures/twins.h"

#include <chrono>
#include <cstddef>
#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "tests/captures/receivers.h"
#include "tests/captures/recordings.h"

/// Where the recordings are, each twin is held against its own.
namespace tribus::twins_test {
namespace {

using std::chrono::microseconds;
using test::Capture;

std::vector<std::string_view> recorded_names() {
    std::vector<std::string_view> names;
    for (const test::Receiver& receiver : test::receivers()) {
        if (test::captures().size() > 1) {
            names.push_back(receiver.name);
        }
    }
    return names;
}

class Twins : public testing::TestWithParam<std::string_view> {
  protected:
    static std::vector<Burst> bursts(Capture capture) {
        return test::recording_of(std::string(GetParam()) + ".timed.txt", capture).bursts;
    }
};

// Without recordings there is nothing to hold a twin against.
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(Twins);
INSTANTIATE_TEST_SUITE_P(Receivers, Twins, testing::ValuesIn(recorded_names()),
                         [](const auto& name) { return std::string(name.param); });

void expect_like(const std::vector<std::vector<int>>& twin,
                 const std::vector<std::vector<int>>& recorded) {
    ASSERT_EQ(twin.size(), recorded.size());
    for (std::size_t frame = 0; frame < twin.size(); ++frame) {
        ASSERT_EQ(twin[frame].size(), recorded[frame].size());
        for (std::size_t channel = 0; channel < twin[frame].size(); ++channel) {
            EXPECT_LE(std::abs(twin[frame][channel] - recorded[frame][channel]), 16)
                << "frame " << frame << ", channel " << channel + 1;
        }
    }
}

TEST_P(Twins, SendsBurstsOfTheSameLengthsAtTheSameTimes) {
    const auto twin = bursts(Capture::twin);
    const auto recorded = bursts(Capture::recording);
    ASSERT_EQ(twin.size(), recorded.size());
    for (std::size_t burst = 0; burst < twin.size(); ++burst) {
        ASSERT_EQ(twin[burst].bytes.size(), recorded[burst].bytes.size()) << burst;
        EXPECT_LE(std::chrono::abs(*twin[burst].start - *recorded[burst].start), microseconds(22))
            << burst;
    }
}

/// The sticks of only one receiver were moved. Others send the same bytes as in their recording.
constexpr std::string_view kMoved = "ibus_servo18_afhds3";

TEST_P(Twins, SendsTheSameBytesAndMovesItsSticksAsTheyWereMoved) {
    if (GetParam() == kMoved) {
        expect_like(test::channel_rows("ibus_servo18_afhds3.channels.csv", Capture::twin),
                    test::channel_rows("ibus_servo18_afhds3.channels.csv", Capture::recording));
        return;
    }
    const auto twin = bursts(Capture::twin);
    const auto recorded = bursts(Capture::recording);
    ASSERT_EQ(twin.size(), recorded.size());
    for (std::size_t burst = 0; burst < twin.size(); ++burst) {
        EXPECT_EQ(twin[burst].bytes, recorded[burst].bytes) << burst;
    }
}

}  // namespace
}  // namespace tribus::twins_test
