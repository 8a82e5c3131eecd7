#include <array>
#include <chrono>
#include <cstdint>
#include <ctime>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/loopback/loopback.h"
#include "tests/reference/plain_crsf.h"

/// A CRSF receiver at 150 Hz drives SBUS and i.Bus through the built program over ptys, and is lost
/// in each of its three ways (docs/protocols/crsf.md, "Loss").
namespace tribus::test::crsf_test {
namespace {

using reference::plain_crsf;
using std::chrono::milliseconds;

constexpr std::uint8_t kGoodLink = 99;

/// One way to lose the link: what goes on coming, and what the log says.
struct Loss {
    const char* name;
    std::optional<std::uint8_t> link_quality;
    const char* told;
};

class CrsfReceiver : public Loopback, public testing::WithParamInterface<Loss> {
  protected:
    /// Sends what is due of the frames that a receiver sends.
    void send(bool channels, std::optional<std::uint8_t> link_quality) {
        const auto now = Clock::now();
        if (channels && now - channels_at_ >= std::chrono::microseconds(6667)) {
            channels_at_ = now;
            std::array<std::uint16_t, 16> raw{};
            raw.fill(992);
            raw[0] = 192;
            wire_.send(plain_crsf(0xC8, 0x16, reference::plain_crsf_packed(raw)));
        }
        if (link_quality && now - statistics_at_ >= milliseconds(100)) {
            statistics_at_ = now;
            wire_.send(plain_crsf(0xC8, 0x14, {60, 70, *link_quality, 9, 1, 4, 3, 0, 0, 0}));
        }
    }
    /// Sends until both outputs have shown channel 1 at 1000 us, as control or as its preset.
    bool both_show(bool channels, std::optional<std::uint8_t> link_quality, bool control) {
        const int wanted = control ? 1000 : 1100;
        bool servos = false;
        bool flight_controller = false;
        return eventually([&] {
            send(channels, link_quality);
            for (const SbusSight& sight : servos_.listen()) {
                servos = sight.failsafe != control && sight.raw[0] == sbus_raw(wanted);
            }
            for (const Sticks& sticks : flight_controller_.listen()) {
                flight_controller = sticks[0] == wanted;
            }
            return servos && flight_controller;
        });
    }

    FarEnd& wire_ = device("radio");
    ServoBank servos_{device("servos")};
    IbusReader flight_controller_{device("fc")};
    Clock::time_point channels_at_{};
    Clock::time_point statistics_at_{};
};

INSTANTIATE_TEST_SUITE_P(Losses, CrsfReceiver,
                         testing::Values(Loss{"RadioLost", 0, "the receiver says failsafe"},
                                         Loss{"ChannelsMissing", kGoodLink,
                                              "channels that were there are missing"},
                                         Loss{"WireSilent", std::nullopt, "no bytes any more"}),
                         [](const auto& loss) { return loss.param.name; });

TEST_P(CrsfReceiver, DrivesBothOutputsAndIsLostWithItsCause) {
    Program& program = run(write_config(R"(
[input.radio]
protocol = "crsf"
device = "@radio"

[output.servos]
protocol = "sbus"
device = "@servos"

[output.fc]
protocol = "ibus"
device = "@fc"

[pipeline.main]
from = "radio"
to = ["servos", "fc"]

[pipeline.main.failsafe]
action = "preset"
preset = { 1 = 1100, other = 1500 }
)"));
    EXPECT_TRUE(both_show(true, kGoodLink, true)) << program.errors();
    EXPECT_TRUE(both_show(false, GetParam().link_quality, false)) << program.errors();
    EXPECT_TRUE(program.says(GetParam().told)) << program.errors();
    EXPECT_TRUE(both_show(true, kGoodLink, true)) << program.errors();
    EXPECT_EQ(servos_.strays(), 0U);
    EXPECT_EQ(flight_controller_.strays(), 0U);
    expect_clean_end(program);
}

class FastCrsf : public Loopback {};

/// 500 and 1000 frames a second on two pipelines at once: none is lost on the way in, and the
/// newest values come out.
TEST_F(FastCrsf, TwoPipelinesTakeEveryFrame) {
    constexpr int kFrames = 1000;
    FarEnd& slow = device("slow");
    FarEnd& fast = device("fast");
    FarEnd& slow_out = device("slow_out");
    FarEnd& fast_out = device("fast_out");
    std::string config;
    for (const std::string name : {"slow", "fast"}) {
        config += "[input." + name + "]\nprotocol = \"crsf\"\ndevice = \"@" + name +
                  "\"\ntimeout = \"5s\"\n[output." + name +
                  "]\nprotocol = \"crsf\"\nperiod = \"2ms\"\ndevice = \"@" + name +
                  "_out\"\n[pipeline." + name + "]\nfrom = \"" + name + "\"\nto = \"" + name +
                  "\"\n";
    }
    Program& program = run(write_config(config));
    std::array<std::uint16_t, 16> raw{};
    raw.fill(992);
    const auto frame = [&raw](int number) {
        raw[0] = static_cast<std::uint16_t>(200 + number);
        return plain_crsf(0xC8, 0x16, reference::plain_crsf_packed(raw));
    };
    const auto comes_out = [](FarEnd& wire, int last, const auto& meanwhile) {
        Bytes heard;
        return eventually([&] {
            meanwhile();
            const Bytes more = wire.receive();
            heard.insert(heard.end(), more.begin(), more.end());
            const auto frames = reference::plain_crsf_frames(heard);
            return !frames.empty() && frames.back().payload.size() == 22 &&
                   reference::plain_bits(frames.back().payload, 0, 11) == 200U + unsigned(last);
        });
    };
    const auto frames_in = [&] {
        Program& status = start(
            {"monitor", "--socket", (folder() / "control").string(), "--once", "--format", "json"});
        EXPECT_EQ(status.end(), 0);
        const auto told = nlohmann::json::parse(status.output(), nullptr, false);
        return told.is_object() ? std::array{told["inputs"][0]["frames"].get<int>(),
                                             told["inputs"][1]["frames"].get<int>()}
                                : std::array{-1, -1};
    };
    // The program throws away what came before it reads for the first time.
    constexpr int kBefore = 1500;
    for (const auto& [in, out] : {std::pair(&slow, &slow_out), std::pair(&fast, &fast_out)}) {
        EXPECT_TRUE(comes_out(*out, kBefore, [&, wire = in] { wire->send(frame(kBefore)); }));
    }
    // Figures are up to 150 ms old.
    auto counted = frames_in();
    EXPECT_TRUE(eventually([&] {
        const timespec pause{.tv_sec = 0, .tv_nsec = 300'000'000};
        ::nanosleep(&pause, nullptr);
        const auto earlier = std::exchange(counted, frames_in());
        return earlier == counted;
    }));
    const auto begin = Clock::now();
    for (int sent = 0; sent < kFrames;) {
        if (Clock::now() - begin >= sent * milliseconds(1)) {
            fast.send(frame(sent));
            if (sent % 2 == 0) {
                slow.send(frame(sent));
            }
            ++sent;
        }
        slow_out.receive();
        fast_out.receive();
    }
    const auto nothing = [] {};
    EXPECT_TRUE(comes_out(slow_out, kFrames - 2, nothing)) << program.errors();
    EXPECT_TRUE(comes_out(fast_out, kFrames - 1, nothing)) << program.errors();
    const std::array expected{counted[0] + kFrames / 2, counted[1] + kFrames};
    eventually([&] { return frames_in() == expected; });
    EXPECT_EQ(frames_in(), expected);
    expect_clean_end(program);
}

}  // namespace
}  // namespace tribus::test::crsf_test
