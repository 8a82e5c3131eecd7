#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/dbc_maps.h"
#include "transports/codecs/dbc/checksum.h"
#include "transports/codecs/dbc/dbc.h"

namespace tribus::encoder_test {
namespace {

using namespace test;
using Bytes = std::vector<std::uint8_t>;

DbcMap sent_map(std::string_view dbc, std::string_view signals, std::string_view cycles = {}) {
    return dbc_map(dbc_settings(dbc, signals, cycles), SettingScope::output);
}

/// Returns the data of the first frame that is sent for a snapshot.
Bytes sent(std::string_view dbc, std::string_view signals, const ChannelFrame& snapshot) {
    DbcEncoder encoder(sent_map(dbc, signals));
    const CanFrames frames = frames_of(encoder, snapshot, at(0));
    return frames.empty() ? Bytes{} : bytes_of(frames[0]);
}

ChannelFrame failsafe(ChannelFrame snapshot) {
    snapshot.frame_lost = snapshot.failsafe = true;
    return snapshot;
}

constexpr std::string_view kDrive = R"(
BO_ 304 Command: 8 A
 SG_ Mode : 0|8@1+ (1,0) [0|0] "" B
 SG_ Speed : 23|16@0- (0.001,0) [-1.5|1.5] "m/s" B
 SG_ Pulse : 32|12@1+ (0.5,476) [476|2523] "us" B
 SG_ Failsafe : 44|1@1+ (1,0) [0|1] "" B
 SG_ Lost : 45|1@1+ (1,0) [0|1] "" B
 SG_ Good : 46|2@1+ (1,0) [0|3] "" B
 SG_ Count : 48|4@1+ (1,0) [0|15] "" B
 SG_ Check : 56|8@1+ (1,0) [0|255] "" B
)";

TEST(DbcEncoder, WritesPhysicalValuesInTheLayoutOfTheFile) {
    // 1700 us in 1000 to 2000 are 0.6 m/s, raw 600 = 0x0258, high byte first. 1500.5 us are raw
    // (1500.5 - 476) * 2 = 2049 = 0x801, low byte first.
    EXPECT_EQ(sent(kDrive, R"({"Command": {"Mode": {"fixed": 1}, "Speed": 1, "Pulse": 2}})",
                   channels({1700, 1500.5})),
              (Bytes{0x01, 0, 0x02, 0x58, 0x01, 0x08, 0, 0}));
}

TEST(DbcEncoder, TheUserMayGiveTheLine) {
    // With 2000 us for -1 m/s and 1000 us for 1 m/s, 1100 us are 0.8 m/s = raw 800 = 0x0320.
    EXPECT_EQ(
        sent(kDrive,
             R"({"Command": {"Speed": {"channel": 1, "value": [-1, 1], "us": [2000, 1000]}}})",
             channels({1100})),
        (Bytes{0, 0, 0x03, 0x20, 0, 0, 0, 0}));
}

TEST(DbcEncoder, KeepsToTheRangeOfTheFile) {
    // 2500 us would be 3 m/s; the file allows 1.5 m/s = 1500 = 0x05DC.
    EXPECT_EQ(sent(kDrive, R"({"Command": {"Speed": 1}})", channels({2500})),
              (Bytes{0, 0, 0x05, 0xDC, 0, 0, 0, 0}));
}

TEST(DbcEncoder, AnAbsentChannelWithoutACodeIsTheCentre) {
    EXPECT_EQ(sent(kDrive, R"({"Command": {"Speed": 2}})", channels({2000})),
              (Bytes{0, 0, 0, 0, 0, 0, 0, 0}));
}

TEST(DbcEncoder, TheCauseIsItsNumber) {
    constexpr std::string_view kCause = R"({"Command": {"Speed": 1, "Count": {"flag": "cause"}}})";
    ChannelFrame snapshot = channels({1500});
    snapshot.cause = LinkCause::good;
    EXPECT_EQ(sent(kDrive, kCause, snapshot), (Bytes{0, 0, 0, 0, 0, 0, 0, 0}));
    snapshot.cause = LinkCause::radio_lost;
    EXPECT_EQ(sent(kDrive, kCause, snapshot), (Bytes{0, 0, 0, 0, 0, 0, 4, 0}));
    snapshot.cause = LinkCause::implausible;
    EXPECT_EQ(sent(kDrive, kCause, snapshot), (Bytes{0, 0, 0, 0, 0, 0, 6, 0}));
    for (const LinkCause not_live : {LinkCause::late, LinkCause::unproved}) {
        snapshot.cause = not_live;
        EXPECT_EQ(sent(kDrive, kCause, snapshot), (Bytes{0, 0, 0, 0, 0, 0, 5, 0}));
    }
}

TEST(DbcEncoder, FlagsTellTheStateOfTheLink) {
    constexpr std::string_view kFlags =
        R"({"Command": {"Speed": 1, "Failsafe": {"flag": "failsafe"},
            "Lost": {"flag": "frame_lost"}, "Good": {"flag": "good"}}})";
    ChannelFrame snapshot = channels({1500});
    EXPECT_EQ(sent(kDrive, kFlags, snapshot), (Bytes{0, 0, 0, 0, 0, 0x40, 0, 0}));
    snapshot.frame_lost = true;
    EXPECT_EQ(sent(kDrive, kFlags, snapshot), (Bytes{0, 0, 0, 0, 0, 0x20, 0, 0}));
    EXPECT_EQ(sent(kDrive, kFlags, failsafe(snapshot)), (Bytes{0, 0, 0, 0, 0, 0x30, 0, 0}));
}

TEST(DbcEncoder, TheCounterGoesToItsMostAndStartsAgain) {
    DbcEncoder encoder(
        sent_map(kDrive, R"({"Command": {"Speed": 1, "Count": {"counter": true, "most": 2}}})"));
    std::vector<int> counts;
    for (int i = 0; i < 5; ++i) {
        counts.push_back(frames_of(encoder, channels({1500}), at(20 * i)).at(0).data[6]);
    }
    EXPECT_EQ(counts, (std::vector{0, 1, 2, 0, 1}));
}

TEST(DbcEncoder, GoesOnWhereAnotherConfigurationTakesOver) {
    const auto map = [] {
        return sent_map(kDrive, R"({"Command": {"Speed": 1, "Count": {"counter": true}}})",
                        R"({"Command": "50ms"})");
    };
    DbcEncoder before(map());
    DbcEncoder next(map());
    EXPECT_EQ(frames_of(before, channels({1500}), at(0)).size(), 1U);
    next.continue_from(before);
    for (const int when : {10, 40, 50, 60, 100}) {
        EXPECT_EQ(frames_of(next, channels({1500}), at(when)),
                  frames_of(before, channels({1500}), at(when)))
            << when << " ms after the reload";
    }
}

constexpr std::string_view kCodes = R"(
BO_ 1 M: 4 A
 SG_ Unsigned : 0|8@1+ (1,0) [0|0] "" B
 SG_ Signed : 8|8@1- (1,0) [0|0] "" B
 SG_ Wide : 16|16@1+ (1,0) [0|0] "us" B
)";
constexpr std::string_view kBothCodes =
    R"({"M": {"Unsigned": {"channel": 1, "value": [0, 250], "error": 254, "not_available": 255},
              "Signed": {"channel": 2, "value": [-127, 127], "not_available": -128},
              "Wide": {"channel": 3, "error": 65535}}})";

TEST(DbcEncoder, AnAbsentChannelIsNotAvailableElseAnError) {
    EXPECT_EQ(sent(kCodes, kBothCodes, channels({})), (Bytes{0xFF, 0x80, 0xFF, 0xFF}));
}

TEST(DbcEncoder, InFailsafeAChannelIsAnErrorElseNotAvailable) {
    EXPECT_EQ(sent(kCodes, kBothCodes, failsafe(channels({1500, 1500, 1500}))),
              (Bytes{0xFE, 0x80, 0xFF, 0xFF}));
}

TEST(DbcEncoder, AValueBeyondItsRangeNeverComesOutAsACode) {
    // 2500 us would be raw 375, limited to 255; -1000 us would be raw -381, limited to -128 = 0x80.
    EXPECT_EQ(sent(kCodes, kBothCodes, channels({2500, -1000, 1500})),
              (Bytes{0xFD, 0x81, 0xDC, 0x05}));
}

TEST(DbcEncoder, ACodeAtZeroIsStepped) {
    EXPECT_EQ(sent(kCodes,
                   R"({"M": {"Unsigned": {"channel": 1, "value": [1, 100], "error": 0,
                                          "not_available": 1}}})",
                   channels({500})),
              (Bytes{0x02, 0, 0, 0}));
}

const std::string kJoystick = R"(
BO_ 2365445683 BJM1: 8 A
 SG_ XNeutral : 0|2@1+ (1,0) [0|1] "" B
 SG_ XNegative : 2|2@1+ (1,0) [0|1] "" B
 SG_ XPositive : 4|2@1+ (1,0) [0|1] "" B
 SG_ XPosition : 6|10@1+ (0.1,0) [0|100] "%" B
 SG_ Button : 46|2@1+ (1,0) [0|1] "" B
)" + j1939_frames({2365445683});
constexpr std::string_view kJoystickSignals =
    R"({"BJM1": {"XPosition": {"channel": 1, "negative": "XNegative", "positive": "XPositive",
                               "neutral": "XNeutral", "error": 1022, "not_available": 1023},
                 "Button": {"channel": 2, "value": [0, 1], "error": 2, "not_available": 3}}})";

Bytes joystick(const ChannelFrame& snapshot) {
    return sent(kJoystick, kJoystickSignals, snapshot);
}

// docs/protocols/can.md, "J1939 joysticks": neutral, negative and positive in the low six bits,
// then the magnitude in 0.1 %. Unused bits are ones.
TEST(DbcEncoder, WritesAMagnitudeWithItsDirection) {
    // 100 % = 1000 = 0b11'1110'1000: low two bits 00 in byte 0, the rest 0xFA in byte 1.
    EXPECT_EQ(joystick(channels({2000, 2000})),
              (Bytes{0x10, 0xFA, 0xFF, 0xFF, 0xFF, 0x7F, 0xFF, 0xFF}));
    EXPECT_EQ(joystick(channels({1000, 1000})),
              (Bytes{0x04, 0xFA, 0xFF, 0xFF, 0xFF, 0x3F, 0xFF, 0xFF}));
    EXPECT_EQ(joystick(channels({1500, 1000})),
              (Bytes{0x01, 0x00, 0xFF, 0xFF, 0xFF, 0x3F, 0xFF, 0xFF}));
}

TEST(DbcEncoder, WritesTheCodesOfAJoystickIntoAllItsSignals) {
    // 1022 = 0b11'1111'1110; each status 2.
    EXPECT_EQ(joystick(failsafe(channels({1500, 1000}))),
              (Bytes{0xAA, 0xFF, 0xFF, 0xFF, 0xFF, 0xBF, 0xFF, 0xFF}));
    EXPECT_EQ(joystick(channels({})), (Bytes{0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF}));
}

TEST(DbcEncoder, SendsExtendedIdsAsTheFileHasThem) {
    DbcEncoder encoder(sent_map(kJoystick, kJoystickSignals));
    const CanFrame frame = frames_of(encoder, channels({1500}), at(0)).at(0);
    EXPECT_EQ(frame.id, 0x0CFDD633U);
    EXPECT_TRUE(frame.extended);
    EXPECT_FALSE(frame.fd);
    EXPECT_FALSE(encoder.uses_fd());
}

TEST(DbcEncoder, SendsFdFramesWhereTheMessageIsLong) {
    DbcEncoder encoder(
        sent_map("BO_ 1 M: 12 A\n SG_ S : 80|16@1+ (1,0) [0|0] \"us\" B\n"
                 "BA_DEF_ BO_ \"CANFD_BRS\" ENUM \"0\",\"1\";\n"
                 "BA_ \"CANFD_BRS\" BO_ 1 1;\n",
                 R"({"M": {"S": 1}})"));
    const CanFrame frame = frames_of(encoder, channels({1500}), at(0)).at(0);
    EXPECT_TRUE(encoder.uses_fd());
    EXPECT_TRUE(frame.fd);
    EXPECT_TRUE(frame.bit_rate_switch);
    EXPECT_EQ(bytes_of(frame), (Bytes{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xDC, 0x05}));
}

constexpr std::string_view kPages = R"(
BO_ 1 M: 3 A
 SG_ Page M : 0|8@1+ (1,0) [0|0] "" B
 SG_ Common : 8|8@1+ (1,0) [0|100] "" B
 SG_ First m3 : 16|8@1+ (1,0) [0|100] "" B
 SG_ Second m7 : 16|8@1+ (1,0) [0|100] "" B
)";

TEST(DbcEncoder, SendsEachPageWithWhatAllPagesHave) {
    DbcEncoder encoder(sent_map(kPages, R"({"M": {"Common": 1, "First": 2, "Second": 3}})"));
    const CanFrames frames = frames_of(encoder, channels({1100, 1200, 1300}), at(0));
    ASSERT_EQ(frames.size(), 2U);
    EXPECT_EQ(bytes_of(frames[0]), (Bytes{3, 10, 20}));
    EXPECT_EQ(bytes_of(frames[1]), (Bytes{7, 10, 30}));
}

TEST(DbcEncoder, ASignalOfSeveralPagesIsInEachThatIsSent) {
    const std::string dbc = std::string(kPages) + " SG_ Both m3 : 8|8@1+ (1,0) [0|100] \"\" B\n" +
                            "SG_MUL_VAL_ 1 Both Page 2-7;\n";
    DbcEncoder encoder(sent_map(dbc, R"({"M": {"Both": 1, "Second": 3}})"));
    const CanFrames frames = frames_of(encoder, channels({1100, 1200, 1300}), at(0));
    ASSERT_EQ(frames.size(), 2U);
    EXPECT_EQ(bytes_of(frames[0]), (Bytes{2, 10, 0}));
    EXPECT_EQ(bytes_of(frames[1]), (Bytes{7, 10, 30}));
}

constexpr std::string_view kCyclic = R"(
BO_ 1 Stick: 1 A
 SG_ S : 0|8@1+ (1,0) [0|100] "" B
BO_ 2 Slow: 1 A
 SG_ Failsafe : 0|1@1+ (1,0) [0|1] "" B
BO_ 1797 Heartbeat: 1 A
 SG_ State : 0|8@1+ (1,0) [0|0] "" B
)";

std::vector<int> ids(const CanFrames& frames) {
    std::vector<int> ids;
    for (const CanFrame& frame : frames) {
        ids.push_back(static_cast<int>(frame.id));
    }
    return ids;
}

TEST(DbcEncoder, SendsAHeartbeatOnlyEverySecond) {
    DbcEncoder encoder(sent_map(kCyclic,
                                R"({"Stick": {"S": 1}, "Heartbeat": {"State": {"fixed": 5}}})",
                                R"({"Heartbeat": "1s"})"));
    std::vector<int> heartbeats;
    for (int time = 0; time < 3000; time += 20) {
        const CanFrames frames = frames_of(encoder, channels({1500}), at(time));
        EXPECT_EQ(frames.front().id, 1U);
        if (frames.size() == 2) {
            EXPECT_EQ(bytes_of(frames[1]), Bytes{5});
            heartbeats.push_back(time);
        }
    }
    EXPECT_EQ(heartbeats, (std::vector{0, 1000, 2000}));
}

TEST(DbcEncoder, ASlowMessageTellsFailsafeAtOnce) {
    DbcEncoder encoder(
        sent_map(kCyclic, R"({"Stick": {"S": 1}, "Slow": {"Failsafe": {"flag": "failsafe"}}})",
                 R"({"Slow": "1s"})"));
    EXPECT_EQ(ids(frames_of(encoder, channels({1500}), at(0))), (std::vector{1, 2}));
    EXPECT_EQ(ids(frames_of(encoder, channels({1500}), at(20))), (std::vector{1}));
    EXPECT_EQ(ids(frames_of(encoder, failsafe(channels({1500})), at(40))), (std::vector{1, 2}));
    EXPECT_EQ(ids(frames_of(encoder, failsafe(channels({1500})), at(60))), (std::vector{1}));
}

TEST(DbcEncoder, TheChecksumCoversWhatIsSent) {
    // AgileX: id 0x130 low and high, length, bytes: 0x30 + 0x01 + 8 + 0x01 + 0x02 + 0x58 = 0x94.
    EXPECT_EQ(sent(kDrive,
                   R"({"Command": {"Check": {"checksum": "agilex"}, "Mode": {"fixed": 1},
                                   "Speed": 1}})",
                   channels({1700})),
              (Bytes{0x01, 0, 0x02, 0x58, 0, 0, 0, 0x94}));
}

std::uint64_t checksum(DbcChecksumKind kind, const Bytes& data, std::size_t byte,
                       std::uint16_t data_id = 0, std::uint32_t id = 0) {
    DbcSignal signal;
    signal.start_bit = static_cast<unsigned>(byte * 8);
    signal.bit_length = kind == DbcChecksumKind::p05 ? 16 : 8;
    return dbc_checksum({kind, DbcLayout(signal), byte, data_id}, id, data);
}

/// "123456789" with the byte of the checksum, which does not count, in the middle.
const Bytes kDigitsAround{'1', '2', '3', '4', 0xEE, '5', '6', '7', '8', '9'};

// The check values of the CRC catalogues for "123456789".
TEST(DbcChecksum, CrcsHaveTheCheckValuesOfTheCatalogues) {
    EXPECT_EQ(checksum(DbcChecksumKind::crc8_1d, kDigitsAround, 4), 0x4BU);
    EXPECT_EQ(checksum(DbcChecksumKind::crc8_2f, kDigitsAround, 4), 0xDFU);
}

TEST(DbcChecksum, XorAndSum) {
    // 1 ^ 2 ^ ... ^ 9 of the digits is 0x31; their sum is 477 = 0x1DD.
    EXPECT_EQ(checksum(DbcChecksumKind::xor8, kDigitsAround, 4), 0x31U);
    EXPECT_EQ(checksum(DbcChecksumKind::sum8, kDigitsAround, 4), 0xDDU);
}

// By hand: 0x30 + 0x01 + 8 + 0x01 + 0x1E + 0xE2 + 0x05 = 0x13F.
TEST(DbcChecksum, AgilexAddsIdAndLength) {
    EXPECT_EQ(
        checksum(DbcChecksumKind::agilex, {0x01, 0, 0x1E, 0xE2, 0, 0, 0x05, 0xAA}, 7, 0, 0x130),
        0x3FU);
}

// e2e_vectors.json, from the examples of the AUTOSAR specification.
TEST(DbcChecksum, AutosarProfiles) {
    EXPECT_EQ(checksum(DbcChecksumKind::p01, {0, 0x01, 0, 0, 0, 0, 0, 0}, 0, 0x0123), 0x91U);
    EXPECT_EQ(checksum(DbcChecksumKind::p05, {0, 0, 0, 0, 0, 0, 0, 0}, 0, 0x1234), 0xCA1CU);
}

TEST(DbcEncoder, WhatBecomesFrameLostIsToldBeforeTheCycleEnds) {
    DbcEncoder encoder(sent_map(kDrive,
                                R"({"Command": {"Speed": 1, "Lost": {"flag": "frame_lost"}}})",
                                R"({"Command": "1s"})"));
    ChannelFrame snapshot = channels({1500});
    EXPECT_EQ(frames_of(encoder, snapshot, at(0)).size(), 1U);
    EXPECT_EQ(frames_of(encoder, snapshot, at(20)).size(), 0U);
    snapshot.frame_lost = true;
    EXPECT_EQ(frames_of(encoder, snapshot, at(40)).size(), 1U);
}

// CANopen: SYNC is id 0x80 without data; a node with a counter sends 1 to 240 in one byte.
constexpr std::string_view kSync = R"(BO_ 128 SYNC: 0 A
BO_ 129 Counted: 1 A
 SG_ Cnt : 0|8@1+ (1,0) [0|240] "" B
)";

TEST(DbcEncoder, SendsAMessageWithoutData) {
    DbcEncoder encoder(sent_map(kSync, R"({"SYNC": {}})", R"({"SYNC": "10ms"})"));
    for (int time = 0; time < 100; time += 10) {
        const CanFrames sync = frames_of(encoder, channels({}), at(time));
        ASSERT_EQ(sync.size(), 1U) << time;
        EXPECT_EQ(sync[0].id, 128U);
        EXPECT_EQ(sync[0].length, 0);
    }
    EXPECT_EQ(encoder.needed_channels(channels({})), 0U);
}

TEST(DbcEncoder, SendsAMessageThatOnlyCounts) {
    DbcEncoder encoder(sent_map(kSync, R"({"Counted": {"Cnt": {"counter": true, "most": 2}}})"));
    std::vector<Bytes> sent;
    for (int time = 0; time < 80; time += 20) {
        sent.push_back(bytes_of(frames_of(encoder, failsafe(channels({})), at(time)).at(0)));
    }
    EXPECT_EQ(sent, (std::vector<Bytes>{{0}, {1}, {2}, {0}}));
}

TEST(DbcEncoder, MarksHeldValuesOnlyIfEachMessageWithChannelsDoes) {
    constexpr std::string_view kTwo = R"(BO_ 1 M: 2 A
 SG_ X : 0|8@1+ (1,0) [0|100] "" B
 SG_ Lost : 8|1@1+ (1,0) [0|1] "" B
BO_ 2 N: 1 A
 SG_ Y : 0|8@1+ (1,0) [0|100] "" B
)";
    const std::string marked = R"("M": {"X": 1, "Lost": {"flag": "frame_lost"}})";
    EXPECT_TRUE(DbcEncoder(sent_map(kTwo, "{" + marked + "}")).marks_frame_lost());
    EXPECT_TRUE(DbcEncoder(sent_map(kTwo, "{" + marked + R"(, "N": {"Y": {"fixed": 1}}})"))
                    .marks_frame_lost());
    EXPECT_FALSE(
        DbcEncoder(sent_map(kTwo, "{" + marked + R"(, "N": {"Y": 2}})")).marks_frame_lost());
}

}  // namespace
}  // namespace tribus::encoder_test
