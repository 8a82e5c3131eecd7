#include <gtest/gtest.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/dbc_maps.h"
#include "transports/codecs/dbc/checksum.h"
#include "transports/codecs/dbc/dbc.h"

namespace tribus::decoder_test {
namespace {

using namespace test;
using Bytes = std::vector<std::uint8_t>;

/// Returns what a decoder publishes for one frame.
std::optional<ChannelFrame> received(std::string_view dbc, std::string_view signals,
                                     const CanFrame& frame) {
    DbcDecoder decoder(received_map(dbc, signals));
    return decoder.next(frame, at(0));
}

std::optional<double> microseconds(const std::optional<ChannelFrame>& snapshot,
                                   std::size_t channel) {
    const auto pulse = snapshot ? snapshot->channel(channel) : std::nullopt;
    return pulse ? std::optional(pulse->microseconds()) : std::nullopt;
}

constexpr std::string_view kDrive = R"(
BO_ 304 Command: 8 A
 SG_ Mode : 0|8@1+ (1,0) [0|0] "" B
 SG_ Speed : 23|16@0- (0.001,0) [-1.5|1.5] "m/s" B
 SG_ Pulse : 32|12@1+ (0.5,476) [476|2523] "us" B
 SG_ Failsafe : 44|2@1+ (1,0) [0|3] "" B
 SG_ Lost : 46|1@1+ (1,0) [0|1] "" B
 SG_ Good : 48|2@1+ (1,0) [0|3] "" B
 SG_ Check : 56|8@1+ (1,0) [0|255] "" B
)";

CanFrame command(const Bytes& data) {
    return standard_frame(304, data);
}

TEST(DbcDecoder, ReadsPhysicalValuesInTheLayoutOfTheFile) {
    // The bytes of the encoder's test: 0.6 m/s is 1700 us, raw 2049 is 1500.5 us.
    const auto snapshot = received(kDrive, R"({"Command": {"Speed": 1, "Pulse": 2}})",
                                   command({0x01, 0, 0x02, 0x58, 0x01, 0x08, 0, 0}));
    EXPECT_EQ(microseconds(snapshot, 0), 1700);
    EXPECT_EQ(microseconds(snapshot, 1), 1500.5);
    EXPECT_EQ(microseconds(snapshot, 2), std::nullopt);
    ASSERT_TRUE(snapshot);
    EXPECT_TRUE(snapshot->good());
    EXPECT_EQ(snapshot->origin, Origin::dbc);
    EXPECT_EQ(snapshot->received, at(0));
}

TEST(DbcDecoder, PassesOtherIdsOver) {
    DbcDecoder decoder(received_map(kDrive, R"({"Command": {"Speed": 1}})"));
    EXPECT_FALSE(decoder.next(standard_frame(305, Bytes(8)), at(0)));
    EXPECT_FALSE(decoder.next(extended_frame(304, Bytes(8)), at(0)));
    EXPECT_EQ(rejected(decoder, "length"), 0U);
}

TEST(DbcDecoder, RefusesShortRemoteAndFdFrames) {
    DbcDecoder decoder(received_map(kDrive, R"({"Command": {"Speed": 1}})"));
    CanFrame remote = command(Bytes(8));
    remote.remote = true;
    CanFrame fd = command(Bytes(8));
    fd.fd = true;
    for (const CanFrame& frame : {command(Bytes(7)), remote, fd}) {
        EXPECT_FALSE(decoder.next(frame, at(0)));
    }
    EXPECT_EQ(rejected(decoder, "length"), 3U);
    EXPECT_TRUE(decoder.next(command(Bytes(8)), at(0)));
}

TEST(DbcDecoder, ReadsFdFrames) {
    const std::string_view dbc = "BO_ 1 M: 12 A\n SG_ S : 80|16@1+ (1,0) [0|0] \"us\" B\n";
    DbcDecoder decoder(received_map(dbc, R"({"M": {"S": 1}})"));
    EXPECT_TRUE(decoder.uses_fd());
    CanFrame frame = standard_frame(1, {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xDC, 0x05});
    frame.fd = true;
    EXPECT_EQ(microseconds(decoder.next(frame, at(0)), 0), 1500);
}

TEST(DbcDecoder, AnythingButAPlainZeroInAFailsafeFlagIsFailsafe) {
    constexpr std::string_view kSignals =
        R"({"Command": {"Speed": 1, "Failsafe": {"flag": "failsafe"}}})";
    for (const std::uint8_t bits : Bytes{0, 1, 2, 3}) {
        const auto snapshot =
            received(kDrive, kSignals,
                     command({0, 0, 0, 0, 0, static_cast<std::uint8_t>(bits << 4U), 0, 0}));
        ASSERT_TRUE(snapshot);
        EXPECT_EQ(snapshot->failsafe, bits != 0) << int{bits};
    }
}

TEST(DbcDecoder, OnlyAPlainOneInAGoodFlagIsGood) {
    constexpr std::string_view kSignals = R"({"Command": {"Speed": 1, "Good": {"flag": "good"}}})";
    for (const std::uint8_t bits : Bytes{0, 1, 2, 3}) {
        const auto snapshot = received(kDrive, kSignals, command({0, 0, 0, 0, 0, 0, bits, 0}));
        ASSERT_TRUE(snapshot);
        EXPECT_EQ(snapshot->good(), bits == 1) << int{bits};
    }
}

TEST(DbcDecoder, LostFramesAreNotFailsafe) {
    const auto snapshot =
        received(kDrive, R"({"Command": {"Speed": 1, "Lost": {"flag": "frame_lost"}}})",
                 command({0, 0, 0, 0, 0, 0x40, 0, 0}));
    ASSERT_TRUE(snapshot);
    EXPECT_TRUE(snapshot->frame_lost);
    EXPECT_FALSE(snapshot->failsafe);
}

TEST(DbcDecoder, AnotherFixedValueIsFailsafe) {
    DbcDecoder decoder(received_map(kDrive, R"({"Command": {"Speed": 1, "Mode": {"fixed": 1}}})"));
    EXPECT_TRUE(decoder.next(command({1, 0, 0, 0, 0, 0, 0, 0}), at(0))->good());
    EXPECT_TRUE(decoder.next(command({2, 0, 0, 0, 0, 0, 0, 0}), at(20))->failsafe);
    EXPECT_EQ(rejected(decoder, "wrong fixed"), 1U);
}

TEST(DbcDecoder, AValueBeyondTheRangeOfTheFileIsNone) {
    // 1501 = 0x05DD is 1.501 m/s.
    DbcDecoder decoder(received_map(kDrive, R"({"Command": {"Speed": 1}})"));
    EXPECT_EQ(microseconds(decoder.next(command({0, 0, 0x05, 0xDC, 0, 0, 0, 0}), at(0)), 0), 2000);
    const auto beyond = decoder.next(command({0, 0, 0x05, 0xDD, 0, 0, 0, 0}), at(20));
    ASSERT_TRUE(beyond);
    EXPECT_TRUE(beyond->failsafe);
    EXPECT_FALSE(beyond->has(0));
    EXPECT_EQ(rejected(decoder, "no value"), 1U);
}

TEST(DbcDecoder, RoundingDoesNotTakeTheEndOfTheRangeAway) {
    // 3 * 0.1 is a little more than 0.3.
    const auto snapshot = received("BO_ 1 M: 1 A\n SG_ S : 0|8@1+ (0.1,0) [0|0.3] \"\" B\n",
                                   R"({"M": {"S": 1}})", standard_frame(1, {3}));
    EXPECT_EQ(microseconds(snapshot, 0), 2000);
}

constexpr std::string_view kFloat =
    "BO_ 1 M: 4 A\n SG_ S : 0|32@1- (1,0) [0|0] \"\" B\nSIG_VALTYPE_ 1 S : 1;\n";

TEST(DbcDecoder, NotANumberIsNoValue) {
    constexpr std::string_view kSignals = R"({"M": {"S": {"channel": 1, "value": [0, 1]}}})";
    // IEEE: 0.5, quiet not-a-number, infinity; low byte first.
    EXPECT_EQ(microseconds(received(kFloat, kSignals, standard_frame(1, {0, 0, 0, 0x3F})), 0),
              1500);
    EXPECT_TRUE(received(kFloat, kSignals, standard_frame(1, {0, 0, 0xC0, 0x7F}))->failsafe);
    EXPECT_TRUE(received(kFloat, kSignals, standard_frame(1, {0, 0, 0x80, 0x7F}))->failsafe);
}

constexpr std::string_view kCoded = R"(
BO_ 1 M: 2 A
 SG_ Needed : 0|8@1+ (1,0) [0|0] "" B
 SG_ Extra : 8|8@1- (1,0) [0|0] "" B
)";
constexpr std::string_view kCodedSignals =
    R"({"M": {"Needed": {"channel": 1, "value": [0, 250], "error": 254, "not_available": 255},
              "Extra": {"channel": 2, "value": [-100, 100], "error": -128, "optional": true}}})";

TEST(DbcDecoder, ACodeInANeededChannelIsFailsafe) {
    for (const std::uint8_t code : Bytes{254, 255}) {
        const auto snapshot = received(kCoded, kCodedSignals, standard_frame(1, {code, 0}));
        ASSERT_TRUE(snapshot);
        EXPECT_TRUE(snapshot->failsafe);
        EXPECT_FALSE(snapshot->has(0));
    }
}

TEST(DbcDecoder, ACodeInAnOptionalChannelIsAnAbsentChannel) {
    const auto snapshot = received(kCoded, kCodedSignals, standard_frame(1, {250, 0x80}));
    ASSERT_TRUE(snapshot);
    EXPECT_TRUE(snapshot->good());
    EXPECT_EQ(microseconds(snapshot, 0), 2000);
    EXPECT_FALSE(snapshot->has(1));
}

const std::string kJoystick = R"(
BO_ 2365445886 BJM1: 8 A
 SG_ XNeutral : 0|2@1+ (1,0) [0|1] "" B
 SG_ XNegative : 2|2@1+ (1,0) [0|1] "" B
 SG_ XPositive : 4|2@1+ (1,0) [0|1] "" B
 SG_ XPosition : 6|10@1+ (0.1,0) [0|100] "%" B
)" + j1939_frames({2365445886});
constexpr std::string_view kJoystickSignals =
    R"({"BJM1": {"XPosition": {"channel": 1, "negative": "XNegative", "positive": "XPositive",
                               "neutral": "XNeutral", "error": 1022, "not_available": 1023}}})";

std::optional<double> stick(std::uint8_t first, std::uint8_t second) {
    const auto snapshot =
        received(kJoystick, kJoystickSignals,
                 extended_frame(0x0CFDD633, {first, second, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF}));
    EXPECT_TRUE(snapshot);
    EXPECT_EQ(snapshot && snapshot->good(), microseconds(snapshot, 0).has_value());
    return microseconds(snapshot, 0);
}

// docs/protocols/can.md, "J1939 joysticks": neutral, negative, positive in the low six bits,
// 10 bits of magnitude above them.
TEST(DbcDecoder, ReadsAMagnitudeWithItsDirection) {
    EXPECT_EQ(stick(0x10, 0xFA), 2000);
    EXPECT_EQ(stick(0x04, 0xFA), 1000);
    EXPECT_EQ(stick(0x01, 0x00), 1500);
    EXPECT_EQ(stick(0x00, 0x00), 1500) << "no direction is needed at zero";
    EXPECT_EQ(stick(0x10, 0x7D), 1750);
}

TEST(DbcDecoder, CodesOfAJoystickAreNoValue) {
    EXPECT_EQ(stick(0x90, 0xFF), std::nullopt) << "1022: error";
    EXPECT_EQ(stick(0xD0, 0xFF), std::nullopt) << "1023: not available";
    EXPECT_EQ(stick(0x50, 0xFA), std::nullopt) << "1001: reserved, beyond the range";
    EXPECT_EQ(stick(0x20, 0x7D), std::nullopt) << "positive: error";
    EXPECT_EQ(stick(0x1C, 0x7D), std::nullopt) << "negative: not available";
    EXPECT_EQ(stick(0x13, 0x7D), std::nullopt) << "neutral: not available";
}

TEST(DbcDecoder, DirectionsThatContradictEachOtherAreNoValue) {
    EXPECT_EQ(stick(0x14, 0x7D), std::nullopt) << "negative and positive";
    EXPECT_EQ(stick(0x11, 0x7D), std::nullopt) << "positive and neutral";
    EXPECT_EQ(stick(0x00, 0x7D), std::nullopt) << "out of neutral without a direction";
}

CanFrame joystick_of(std::uint8_t source, std::uint8_t first) {
    return extended_frame(0x0CFDD600U | source, {first, 0xFA, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF});
}

TEST(DbcDecoder, BelievesOneOfSeveralSourcesAtATime) {
    DbcDecoder decoder(received_map(kJoystick, kJoystickSignals));
    EXPECT_TRUE(decoder.next(joystick_of(0x33, 0x10), at(0)));
    EXPECT_FALSE(decoder.next(joystick_of(0x34, 0x04), at(10)));
    CanFrame other_priority = joystick_of(0x33, 0x10);
    other_priority.id = 0x18FDD633;
    EXPECT_TRUE(decoder.next(other_priority, at(100)));
    EXPECT_FALSE(decoder.next(joystick_of(0x34, 0x04), at(1100)));
    EXPECT_EQ(rejected(decoder, "other sender"), 2U);
    EXPECT_EQ(microseconds(decoder.next(joystick_of(0x34, 0x04), at(1101)), 0), 1000);
}

constexpr std::string_view kPages = R"(
BO_ 1 M: 3 A
 SG_ Page M : 0|8@1+ (1,0) [0|0] "" B
 SG_ Common : 8|8@1+ (1,0) [0|100] "" B
 SG_ First m3 : 16|8@1+ (1,0) [0|100] "" B
 SG_ Second m7 : 16|8@1+ (1,0) [0|100] "" B
)";

TEST(DbcDecoder, WaitsForEveryPage) {
    DbcDecoder decoder(received_map(kPages, R"({"M": {"Common": 1, "First": 2, "Second": 3}})"));
    EXPECT_FALSE(decoder.next(standard_frame(1, {3, 10, 20}), at(0)));
    EXPECT_FALSE(decoder.next(standard_frame(1, {4, 99, 99}), at(1)));
    const auto snapshot = decoder.next(standard_frame(1, {7, 11, 30}), at(2));
    EXPECT_EQ(microseconds(snapshot, 0), 1110);
    EXPECT_EQ(microseconds(snapshot, 1), 1200);
    EXPECT_EQ(microseconds(snapshot, 2), 1300);
    ASSERT_TRUE(snapshot);
    EXPECT_EQ(snapshot->received, at(0));
}

TEST(DbcDecoder, PagesMayComeOneInEachCycle) {
    DbcDecoder decoder(received_map(kPages, R"({"M": {"Common": 1, "First": 2, "Second": 3}})",
                                    R"({"M": "20ms"})"));
    int snapshots = 0;
    for (int i = 0; i < 100; ++i) {
        const std::uint8_t page = i % 2 == 0 ? 3 : 7;
        const auto snapshot = decoder.next(standard_frame(1, {page, 10, 20}), at(20 * i));
        snapshots += snapshot && snapshot->good() ? 1 : 0;
    }
    EXPECT_GE(snapshots, 49);
}

TEST(DbcDecoder, ReadsASignalOnAnyPageThatHasIt) {
    const std::string dbc = std::string(kPages) + " SG_ Both m3 : 8|8@1+ (1,0) [0|100] \"\" B\n" +
                            "SG_MUL_VAL_ 1 Both Page 2-7;\n";
    DbcDecoder decoder(received_map(dbc, R"({"M": {"Both": 1}})"));
    EXPECT_EQ(microseconds(decoder.next(standard_frame(1, {5, 10, 0}), at(0)), 0), 1100);
    EXPECT_FALSE(decoder.next(standard_frame(1, {8, 10, 0}), at(1)));
}

TEST(DbcDecoder, FrameLostLastsNoLongerThanTheSenderSaysSo) {
    DbcDecoder decoder(
        received_map(kDrive, R"({"Command": {"Speed": 1, "Lost": {"flag": "frame_lost"}}})"));
    EXPECT_TRUE(decoder.next(command({0, 0, 0, 0, 0, 0x40, 0, 0}), at(0))->frame_lost);
    EXPECT_FALSE(decoder.next(command({0, 0, 0, 0, 0, 0, 0, 0}), at(20))->frame_lost);
}

}  // namespace
}  // namespace tribus::decoder_test
