#include <gtest/gtest.h>

#include "tests/support/dbc_maps.h"
#include "tests/unit/pipelines/engine/can_bench.h"
#include "transports/codecs/dbc/dbc.h"

/// A DBC signal with `optional = true` in a whole engine.
namespace tribus::test::engine_optional_channels_test {
namespace {

using namespace on_can;
using namespace std::chrono_literals;

// The file and the frames of captures/field/can_us/opt.log.
constexpr std::string_view kDbc = R"(BO_ 256 M: 8 A
 SG_ Steer : 0|16@1+ (1,0) [800|2200] "us" B
 SG_ Extra : 16|16@1+ (1,0) [800|2200] "us" B
)";
constexpr std::string_view kSignals =
    R"({"M": {"Steer": 1, "Extra": {"channel": 2, "not_available": 65535, "optional": true}}})";

struct Counted final : StationObserver {
    void wrote(Station, Instant, const Transmission& sent) override {
        const SbusFrame frame = parse_sbus(sent.bytes().first<kSbusFrameLength>());
        ++frames;
        marked += frame.failsafe || frame.frame_lost ? 1 : 0;
        second = frame.raw[1];
    }
    int frames = 0;
    int marked = 0;
    std::uint16_t second = 0;
};

TEST(OptionalChannel, ThatComesAndGoesIsThePresetAndNoLoss) {
    for (const Duration each : {100ms, 300ms, 1000ms, 2000ms}) {
        auto decoder = std::make_unique<DbcDecoder>(
            dbc_map(dbc_settings(kDbc, kSignals), SettingScope::input));
        Engine engine(list(InputSettings{.name = "bus",
                                         .decoder = std::move(decoder),
                                         .supervision = {.timeout = kTimeout,
                                                         .fewer_channels_after = 500ms,
                                                         .optional_channels = 0b10}}),
                      list(sbus_output()));
        Counted seen;
        VirtualLoop loop(engine, seen, at({}));
        for (Duration time{}; time < 10s; time += 20ms) {
            const bool absent = time / each % 2 == 1;
            const auto high = static_cast<std::uint8_t>(absent ? 0xFF : 0x05);
            const auto low = static_cast<std::uint8_t>(absent ? 0xFF : 0x14);
            loop.receive(input_station(0), standard_frame(256, {0x40, 0x06, low, high, 0, 0, 0, 0}),
                         at(time));
            loop.run_until(at(time + 15ms));
            if (time == 1s) {
                seen = {};
            }
            if (time > 1s) {
                // Raw 992 is 1500 us, the preset; 1300 us are 672.
                ASSERT_EQ(seen.second, absent ? 992 : 672) << time.count();
            }
        }
        EXPECT_EQ(seen.marked, 0);
        EXPECT_GT(seen.frames, 800);
    }
}

}  // namespace
}  // namespace tribus::test::engine_optional_channels_test
