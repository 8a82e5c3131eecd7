#include <chrono>
#include <cstddef>
#include <map>
#include <string>

#include <gtest/gtest.h>

#include "tests/captures/recordings.h"
#include "tests/support/can_bits.h"
#include "tests/support/shell.h"
#include "transports/recordings/recording.h"

/// Load of a DroneCAN bus by a recorded 18-channel receiver and by its twin. The program itself
/// makes the frames, at the period of its output.
namespace tribus::dronecan_bus_load_test {
namespace {

using test::BusBits;

struct Second {
    std::size_t frames = 0;
    BusBits bits;
};

class BusLoadOfARecordedReceiver : public testing::TestWithParam<test::Capture> {
  protected:
    /// Returns the load in each whole second in which the receiver sends.
    std::map<std::chrono::seconds::rep, Second> seconds(const std::string& lines) {
        folder_.write("bus.toml",
                      "[input.receiver]\nprotocol = \"ibus\"\ndevice = \"/dev/ttyAMA5\"\n"
                      "[output.bus]\nprotocol = \"dronecan\"\ninterface = \"can0\"\n"
                      "node_id = 42\nschedule = \"grid\"\n" +
                          lines + "[pipeline.main]\nfrom = \"receiver\"\nto = \"bus\"\n");
        const test::Ended ended = test::run_in_shell(
            "cd '" + folder_ / "" + "'; \"$TRIBUS\" simulate bus.toml --in receiver='" +
            test::file_of("ibus_servo18_afhds3.timed.txt", GetParam(), folder_ / "").string() +
            "' --out bus=bus.log");
        EXPECT_EQ(ended.status, 0) << ended.output;
        const auto recording =
            parse_recording(folder_.read("bus.log"), "bus.log", RecordingKind::candump);
        EXPECT_TRUE(recording) << recording.error();
        std::map<std::chrono::seconds::rep, Second> all;
        for (const RecordedCanFrame& recorded :
             recording ? recording->can_frames : std::vector<RecordedCanFrame>{}) {
            const auto second = std::chrono::floor<std::chrono::seconds>(recorded.at).count();
            if (second >= 1 && second < 4) {
                ++all[second].frames;
                all[second].bits += test::bits_on_bus(recorded.frame);
            }
        }
        EXPECT_EQ(all.size(), 3U);
        return all;
    }
    test::TemporaryFolder folder_;
};

INSTANTIATE_TEST_SUITE_P(Both, BusLoadOfARecordedReceiver, testing::ValuesIn(test::captures()),
                         [](const auto& test) { return test::capture_name(test.param); });

TEST_P(BusLoadOfARecordedReceiver, At10MsIs500ClassicFramesASecondAndAbout658BitsForEachFive) {
    for (const auto& [number, second] : seconds("")) {
        EXPECT_EQ(second.frames, 500U) << number;
        EXPECT_NEAR(static_cast<double>(second.bits.nominal) / 100, 658, 6) << number;
    }
}

TEST_P(BusLoadOfARecordedReceiver, At20MsIsHalfOfThat) {
    for (const auto& [number, second] : seconds("period = \"20ms\"\n")) {
        EXPECT_EQ(second.frames, 250U) << number;
        EXPECT_NEAR(static_cast<double>(second.bits.nominal) / 50, 658, 6) << number;
    }
}

/// The upper limits are 57 and 519 bits (docs/protocols/can.md, "Bus load"). The many zeros of
/// these frames get a stuff bit every five bits.
TEST_P(BusLoadOfARecordedReceiver, At10MsIs100FdFramesASecondOf50And454Bits) {
    for (const auto& [number, second] : seconds("fd = true\n")) {
        EXPECT_EQ(second.frames, 100U) << number;
        EXPECT_EQ(second.bits.nominal, 5'000U) << number;
        EXPECT_NEAR(static_cast<double>(second.bits.data) / 100, 454, 6) << number;
    }
}

}  // namespace
}  // namespace tribus::dronecan_bus_load_test
