#include "app/web/recordings/plot_recording.h"

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <sstream>
#include <string>
#include <string_view>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/ibus_frames.h"
#include "tests/support/sbus_frames.h"
#include "tests/support/temporary_folder.h"

namespace tribus::test::plot_recording_test {
namespace {

using namespace web;
using namespace std::chrono_literals;
using nlohmann::json;

constexpr std::string_view kConfiguration = R"([input.receiver]
protocol = "ibus"
device   = "/dev/ttyAMA5"
timeout  = "100ms"
[output.servos]
protocol = "sbus"
device   = "/dev/ttyAMA3"
period   = "14ms"
[pipeline.main]
from = "receiver"
to   = "servos"
[pipeline.main.failsafe]
hold    = "300ms"
recover = "500ms"
)";

/// i.Bus with channel 1 at `us`, all others at 1500.
std::string ibus_line(std::int64_t at_us, int us) {
    Bytes payload;
    for (int channel = 0; channel < 14; ++channel) {
        const int value = channel == 0 ? us : 1500;
        payload.push_back(static_cast<std::uint8_t>(value & 0xFF));
        payload.push_back(static_cast<std::uint8_t>(value >> 8));
    }
    std::string line = std::to_string(at_us);
    for (const std::uint8_t byte : servo_frame(payload, 0x40)) {
        line += fmt::format(" {:02x}", byte);
    }
    return line + "\n";
}

/// A receiver from 0 to 2 s, whose channel 1 moves at 1 s; the output goes on to 4 s.
class PlotRecording : public testing::Test {
  protected:
    PlotRecording() {
        folder_.write("config.toml", std::string(kConfiguration));
        std::string input = "# t_us  bytes\n";
        for (std::int64_t at = 0; at < 2'000'000; at += 7'000) {
            input += ibus_line(at, at < 1'000'000 ? 1100 : 1900);
        }
        folder_.write("input-receiver.txt", input);
        std::string output = "# t_us  bytes\n";
        for (std::int64_t at = 0; at < 4'000'000; at += 14'000) {
            output += fmt::format("{} {}\n", at, kAll992);
        }
        folder_.write("output-servos.txt", output);
    }
    json plot(Duration from, Duration to, std::size_t columns) const {
        const auto made =
            plot_recording(folder_.path(), {.from = from, .to = to, .columns = columns});
        EXPECT_TRUE(made) << made.error();
        std::ostringstream text;
        write_plot(*made, text);
        return json::parse(text.str());
    }
    /// `control 100..2100` in ms, one for each state.
    static std::string states(const json& plot) {
        std::string text;
        for (const json& state : plot["states"]) {
            text +=
                fmt::format("{} {}..{};", state["state"].get<std::string>(),
                            state["from_us"].get<int>() / 1000, state["to_us"].get<int>() / 1000);
        }
        return text;
    }
    static json series(const json& plot, const std::string& name, int channel) {
        for (const json& one : plot["series"]) {
            if (one["name"] == name && one["channel"] == channel) {
                return one;
            }
        }
        return nullptr;
    }

    TemporaryFolder folder_;
};

TEST_F(PlotRecording, HasWhatPassedThePortsAndEndsWithTheRecording) {
    const json all = plot(0s, 1h, 4);
    EXPECT_EQ(all["from_us"], 0);
    EXPECT_EQ(all["to_us"], 3'990'001);
    EXPECT_EQ(all["length_us"], 3'990'001);
    EXPECT_TRUE(all["problem"].is_null());
    const json input = series(all, "receiver", 1);
    EXPECT_EQ(input["kind"], "input");
    EXPECT_EQ(input["least"], json::parse("[1100,1100,1900,null]"));
    EXPECT_EQ(input["greatest"], json::parse("[1100,1900,1900,null]"));
    EXPECT_EQ(series(all, "receiver", 14)["least"][0], 1500);
    EXPECT_TRUE(series(all, "receiver", 15).is_null());
    const json output = series(all, "servos", 1);
    EXPECT_EQ(output["kind"], "output");
    EXPECT_EQ(output["least"], json::parse("[1500,1500,1500,1500]"));
}

TEST_F(PlotRecording, APartHasItsOwnColumns) {
    const json part = plot(999ms, 1010ms, 11);
    EXPECT_EQ(part["from_us"], 999'000);
    EXPECT_EQ(part["to_us"], 1'010'000);
    const json input = series(part, "receiver", 1);
    EXPECT_EQ(input["least"].size(), 11U);
    EXPECT_EQ(input["least"].front(), 1100);
    EXPECT_EQ(input["least"].back(), 1900);
    EXPECT_TRUE(plot(5s, 6s, 10)["series"][0]["least"].empty()) << "behind its end is nothing";
}

/// The simulation begins in failsafe, the real output was in control: nobody knows before
/// `control`.
TEST_F(PlotRecording, TheStateIsUnknownUntilThePastDoesNotMatter) {
    const std::string told = states(plot(0s, 1h, 4));
    EXPECT_EQ(told.find("unknown 0.."), 0U) << told;
    EXPECT_NE(told.find(";control "), std::string::npos) << told;
    EXPECT_EQ(told.find("failsafe"), told.rfind("failsafe")) << "once, after the loss: " << told;
    EXPECT_NE(told.find(";hold 2"), std::string::npos) << told;
    EXPECT_NE(told.find(";failsafe 2"), std::string::npos) << told;
    EXPECT_NE(told.find("..3990;"), std::string::npos) << told;
}

TEST_F(PlotRecording, WithoutAnySignalItIsFailsafeWhenItMustBe) {
    folder_.write("input-receiver.txt", "# t_us  bytes\n");
    EXPECT_EQ(states(plot(0s, 1h, 4)).find("unknown 0..6"), 0U) << "100 + 300 + 200 ms";
    EXPECT_NE(states(plot(0s, 1h, 4)).find(";failsafe 6"), std::string::npos);
    EXPECT_TRUE(series(plot(0s, 1h, 4), "receiver", 1).is_null());
}

TEST_F(PlotRecording, ADamagedFileSaysWhereAndTheRestIsDrawn) {
    std::string input = folder_.read("input-receiver.txt");
    folder_.write("input-receiver.txt", input.substr(0, input.size() / 2) + "\nnonsense\n");
    const json half = plot(0s, 1h, 4);
    EXPECT_NE(half["problem"].get<std::string>().find("input-receiver.txt:"), std::string::npos);
    EXPECT_EQ(series(half, "receiver", 1)["least"][0], 1100);
    EXPECT_EQ(series(half, "servos", 1)["least"][3], 1500);
}

/// A damaged time must not let the simulation run for years.
TEST_F(PlotRecording, ATimeThatNoRecordingHasIsNotBelieved) {
    folder_.write("output-servos.txt", folder_.read("output-servos.txt") + "20000000000 0f\n");
    EXPECT_EQ(plot(0s, kLongestPlot, 4)["length_us"], 3'990'001);
}

TEST_F(PlotRecording, IsAnErrorForWhatIsNone) {
    std::filesystem::remove(folder_.path() / "output-servos.txt");
    EXPECT_TRUE(series(plot(0s, 1h, 4), "servos", 1).is_null()) << "that port was not recorded";
    std::filesystem::remove(folder_.path() / "input-receiver.txt");
    const auto none = plot_recording(folder_.path(), {.from = 0s, .to = 1s, .columns = 1});
    ASSERT_FALSE(none);
    EXPECT_EQ(none.error(), "the recording has no file of an input or output");
    std::filesystem::remove(folder_.path() / "config.toml");
    const auto nothing = plot_recording(folder_.path(), {.from = 0s, .to = 1s, .columns = 1});
    ASSERT_FALSE(nothing);
    EXPECT_NE(nothing.error().find("config.toml"), std::string::npos);
}

}  // namespace
}  // namespace tribus::test::plot_recording_test
