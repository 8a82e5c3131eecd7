#include "transports/codecs/sbus/scale.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <string_view>

namespace tribus::sbus_scale_test {
namespace {

constexpr std::array<std::string_view, 5> kNames{"betaflight", "ardupilot", "px4", "frsky",
                                                 "futaba"};

int written(std::string_view scale, int microseconds) {
    return SbusScale::named(scale)->encode(Pulse::from_microseconds(microseconds));
}
int read(std::string_view scale, int raw) {
    return SbusScale::named(scale)->decode(static_cast<std::uint16_t>(raw)).whole_microseconds();
}

// Values at 1000, 1500 and 2000 us: table of docs/protocols/sbus.md, "Scales".
TEST(SbusScale, WritesTheFieldsValuesAtTheMarks) {
    EXPECT_EQ(written("betaflight", 1000), 192);
    EXPECT_EQ(written("betaflight", 1500), 992);
    EXPECT_EQ(written("betaflight", 2000), 1792);
    EXPECT_EQ(written("px4", 1000), 202);
    EXPECT_EQ(written("px4", 1500), 1002);
    EXPECT_EQ(written("px4", 2000), 1802);
    EXPECT_EQ(written("ardupilot", 1000), 201);
    EXPECT_EQ(written("ardupilot", 1500), 1001);
    EXPECT_EQ(written("ardupilot", 2000), 1801);
}

TEST(SbusScale, MakersEndPointsAreTheirHundredPercent) {
    EXPECT_EQ(written("frsky", 988), 172);
    EXPECT_EQ(written("frsky", 2012), 1811);
    EXPECT_EQ(written("futaba", 1000), 352);
    EXPECT_EQ(written("futaba", 2000), 1696);
    EXPECT_EQ(read("futaba", 1024), 1500);
}

// docs/protocols/sbus.md, "Scales": 352, 1024 and 1696 of Futaba in Betaflight's scale.
TEST(SbusScale, BetaflightsScaleReadsFutabaAsTheFieldKnowsIt) {
    EXPECT_EQ(read("betaflight", 352), 1100);
    EXPECT_EQ(read("betaflight", 1024), 1520);
    EXPECT_EQ(read("betaflight", 1696), 1940);
}

TEST(SbusScale, ReadsBetaflightExactlyInEighths) {
    const SbusScale scale = *SbusScale::named("betaflight");
    for (int raw = 0; raw <= kSbusRawMost; ++raw) {
        ASSERT_EQ(scale.decode(static_cast<std::uint16_t>(raw)).eighths(), 880 * 8 + 5 * raw);
    }
}

// docs/protocols/sbus.md, "Scales": u = (5 v + 4) div 8 + 880; PX4 floor(0.625 v + 0.5) + 874;
// ArduPilot floor(1000 v / 1600) + 875.
TEST(SbusScale, ReadsAllRawValuesAsTheNamedProgramsDo) {
    for (int raw = 0; raw <= kSbusRawMost; ++raw) {
        ASSERT_EQ(read("betaflight", raw), (5 * raw + 4) / 8 + 880);
        ASSERT_EQ(read("px4", raw), static_cast<int>(std::floor(0.625 * raw + 0.5)) + 874);
        ASSERT_EQ(read("ardupilot", raw), raw * 1000 / 1600 + 875);
    }
}

// docs/protocols/sbus.md, "Scales": v = (16 (u - 880) + 5) div 10; PX4 floor((u - 874) / 0.625 +
// 0.5).
TEST(SbusScale, WritesAllMicrosecondsAsTheNamedProgramsDo) {
    for (int microseconds = 880; microseconds <= 2159; ++microseconds) {
        ASSERT_EQ(written("betaflight", microseconds), (16 * (microseconds - 880) + 5) / 10);
        ASSERT_EQ(written("px4", microseconds),
                  std::min(2047, static_cast<int>(std::floor((microseconds - 874) / 0.625 + 0.5))));
    }
}

// The value that ArduPilot itself writes may be one step away, but is read the same.
TEST(SbusScale, ArduPilotReadsTheMicrosecondsThatItsScaleWrites) {
    for (int microseconds = 875; microseconds <= 2154; ++microseconds) {
        ASSERT_EQ(written("ardupilot", microseconds) * 1000 / 1600 + 875, microseconds);
    }
}

TEST(SbusScale, EveryNamedScaleGivesBackAllRawValues) {
    for (const std::string_view name : kNames) {
        const SbusScale scale = *SbusScale::named(name);
        for (int raw = 0; raw <= kSbusRawMost; ++raw) {
            ASSERT_EQ(scale.encode(scale.decode(static_cast<std::uint16_t>(raw))), raw) << name;
        }
    }
}

TEST(SbusScale, EveryNamedScaleGivesBackEveryWholeMicrosecondThatItReaches) {
    for (const std::string_view name : kNames) {
        const int least = SbusScale::named(name)->decode(0).whole_microseconds();
        const int most = SbusScale::named(name)->decode(kSbusRawMost).whole_microseconds();
        for (int microseconds = least; microseconds <= most; ++microseconds) {
            ASSERT_EQ(read(name, written(name, microseconds)), microseconds) << name;
        }
    }
}

// docs/protocols/sbus.md, "Scales": 880 to 2159 us, and 5 or 6 us less in the other two scales.
TEST(SbusScale, ReachesAsFarAsElevenBitsDo) {
    EXPECT_EQ(read("betaflight", 0), 880);
    EXPECT_EQ(read("betaflight", 2047), 2159);
    EXPECT_EQ(read("ardupilot", 0), 875);
    EXPECT_EQ(read("ardupilot", 2047), 2154);
    EXPECT_EQ(read("px4", 0), 874);
    EXPECT_EQ(read("px4", 2047), 2153);
}

TEST(SbusScale, ClampsEveryPulseIntoElevenBits) {
    for (const std::string_view name : kNames) {
        const SbusScale scale = *SbusScale::named(name);
        std::uint16_t last = 0;
        for (int eighths = -32768; eighths <= 32767; ++eighths) {
            const std::uint16_t raw = scale.encode(Pulse::from_eighths(eighths));
            ASSERT_LE(raw, kSbusRawMost);
            ASSERT_GE(raw, last) << name << " falls at " << eighths << " eighths";
            last = raw;
        }
        EXPECT_EQ(scale.encode(Pulse::from_eighths(-32768)), 0);
        EXPECT_EQ(last, kSbusRawMost);
    }
}

TEST(SbusScale, TwoPointsMayFall) {
    const SbusScale scale = SbusScale::through({{172, 1811}, {2012, 988}});
    EXPECT_EQ(scale.decode(172), Pulse::from_microseconds(2012));
    EXPECT_EQ(scale.decode(1811), Pulse::from_microseconds(988));
    for (int raw = 0; raw <= kSbusRawMost; ++raw) {
        ASSERT_EQ(scale.encode(scale.decode(static_cast<std::uint16_t>(raw))), raw);
    }
}

TEST(SbusScale, TheOrderOfTheTwoPointsDoesNotMatter) {
    const SbusScale one = SbusScale::through({{172, 1811}, {988, 2012}});
    const SbusScale other = SbusScale::through({{1811, 172}, {2012, 988}});
    for (std::uint16_t raw = 0; raw <= kSbusRawMost; ++raw) {
        ASSERT_EQ(one.decode(raw), other.decode(raw));
    }
}

TEST(SbusScale, AnUnknownNameIsNone) {
    EXPECT_FALSE(SbusScale::named("spektrum"));
    EXPECT_FALSE(SbusScale::named(""));
}

TEST(SbusScale, ASettingIsANameOrTwoPointsOrAbsent) {
    const SettingValue name = std::string("px4");
    const SettingValue points = TwoPoints{{0, 1600}, {874, 1874}};
    const SettingValue other = true;
    EXPECT_EQ(SbusScale::from_setting(&name).decode(1002).whole_microseconds(), 1500);
    EXPECT_EQ(SbusScale::from_setting(&points).decode(1002).whole_microseconds(), 1500);
    EXPECT_EQ(SbusScale::from_setting(&other).decode(992), kCentrePulse);
    EXPECT_EQ(SbusScale::from_setting(nullptr).decode(992), kCentrePulse);
}

}  // namespace
}  // namespace tribus::sbus_scale_test
