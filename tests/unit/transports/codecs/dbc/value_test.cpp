#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/value_board.h"
#include "tests/support/dbc_maps.h"
#include "transports/codecs/dbc/dbc.h"
#include "transports/codecs/protocol.h"

/// Named values in the messages of an output.
namespace tribus::value_test {
namespace {

using namespace test;
using Bytes = std::vector<std::uint8_t>;

constexpr std::string_view kBattery = R"(
BO_ 256 Battery: 8 A
 SG_ Voltage : 0|16@1+ (0.01,0) [0|60] "V" B
 SG_ Current : 16|16@1- (0.1,0) [0|0] "A" B
 SG_ Temperature : 32|8@1+ (1,-40) [0|0] "degC" B
 SG_ Cells : 40|8@1+ (1,0) [0|0] "" B
 SG_ Count : 48|8@1+ (1,0) [0|255] "" B
 SG_ Check : 56|8@1+ (1,0) [0|255] "" B
BO_ 257 Slow: 1 A
 SG_ Cells : 0|8@1+ (1,0) [0|0] "" B
BA_DEF_ BO_ "GenMsgCycleTime" INT 0 60000;
BA_ "GenMsgCycleTime" BO_ 257 100;
)";

constexpr std::size_t kVoltage = 0;
constexpr std::size_t kCurrent = 1;
constexpr std::size_t kTemperature = 2;
constexpr std::size_t kCells = 3;

ValueBoard board_of_battery() {
    return ValueBoard({{.name = "battery.voltage", .unit = "mV", .lasts = milliseconds(500)},
                       {.name = "battery.current", .unit = "A", .lasts = milliseconds(500)},
                       {.name = "battery.temperature", .unit = "K", .lasts = milliseconds(500)},
                       {.name = "cells", .unit = "", .lasts = kForever}});
}

/// An output that sends only values. All four of them are on the board at 0 ms.
class DbcValueOutput : public testing::Test {
  protected:
    DbcValueOutput() {
        board_.set(kVoltage, 12600, at(0));
        board_.set(kCurrent, -2.5, at(0));
        board_.set(kTemperature, 298.15, at(0));
        board_.set(kCells, 3, at(0));
    }

    /// Returns the data of the first frame at 0 ms, or nothing if none is sent.
    std::optional<Bytes> sent(std::string_view signals, std::string_view dbc = kBattery) {
        DbcEncoder encoder(dbc_map(dbc_settings(dbc, signals), SettingScope::output));
        encoder.use(board_);
        const CanFrames frames = frames_of(encoder, ChannelFrame{}, at(0));
        return frames.empty() ? std::nullopt : std::optional(bytes_of(frames[0]));
    }

    ValueBoard board_ = board_of_battery();
};

TEST_F(DbcValueOutput, ConvertsToTheUnitOfTheSignal) {
    // 12600 mV are 12.6 V, raw 1260 = 0x04EC; 298.15 K are 25 degC, raw 65 = 0x41.
    EXPECT_EQ(sent(R"({"Battery": {"Voltage": {"from": "battery.voltage"},
                                   "Temperature": {"from": "battery.temperature"}}})"),
              (Bytes{0xEC, 0x04, 0, 0, 0x41, 0, 0, 0}));
}

TEST_F(DbcValueOutput, ANumberWhoseUnitOrSignalHasNoneIsTakenAsItIs) {
    // 12600 in 8 bits without a unit saturates at 255.
    EXPECT_EQ(sent(R"({"Battery": {"Cells": {"from": "cells"}}})"),
              (Bytes{0, 0, 0, 0, 0, 3, 0, 0}));
    EXPECT_EQ(sent(R"({"Battery": {"Cells": {"from": "battery.voltage"}}})"),
              (Bytes{0, 0, 0, 0, 0, 0xFF, 0, 0}));
    EXPECT_EQ(sent(R"({"Battery": {"Current": {"from": "cells"}}})"),
              (Bytes{0, 0, 30, 0, 0, 0, 0, 0}));
}

TEST_F(DbcValueOutput, SaturatesAtTheRangeOfTheFile) {
    board_.set(kVoltage, 1e9, at(0));
    // 60 V = 6000 = 0x1770.
    EXPECT_EQ(sent(R"({"Battery": {"Voltage": {"from": "battery.voltage"}}})"),
              (Bytes{0x70, 0x17, 0, 0, 0, 0, 0, 0}));
    board_.set(kVoltage, -1, at(0));
    EXPECT_EQ(sent(R"({"Battery": {"Voltage": {"from": "battery.voltage"}}})"),
              (Bytes{0, 0, 0, 0, 0, 0, 0, 0}));
}

TEST_F(DbcValueOutput, ANumberWhoseUnitDoesNotConvertIsMissing) {
    EXPECT_EQ(sent(R"({"Battery": {"Voltage": {"from": "battery.current"}}})"), std::nullopt);
    EXPECT_EQ(sent(R"({"Battery": {"Voltage": {"from": "battery.current", "not_available": 7}}})"),
              (Bytes{7, 0, 0, 0, 0, 0, 0, 0}));
}

TEST_F(DbcValueOutput, ANegativeNumberIsSentAsSuchOrIsMissing) {
    // -2.5 A in steps of 0.1 A is -25 = 0xFFE7.
    EXPECT_EQ(sent(R"({"Battery": {"Current": {"from": "battery.current"}}})"),
              (Bytes{0, 0, 0xE7, 0xFF, 0, 0, 0, 0}));
    board_.set(kVoltage, -100, at(0));
    EXPECT_EQ(sent(R"({"Battery": {"Voltage": {"from": "battery.voltage"}}})"), std::nullopt);
    board_.set(kCells, -1, at(0));
    EXPECT_EQ(sent(R"({"Battery": {"Cells": {"from": "cells"}}})"), std::nullopt);
    EXPECT_EQ(sent(R"({"Battery": {"Cells": {"from": "cells", "not_available": 255}}})"),
              (Bytes{0, 0, 0, 0, 0, 255, 0, 0}));
    // -45 degC is colder than the signal can say, which has negative numbers.
    board_.set(kTemperature, 228.15, at(0));
    EXPECT_EQ(sent(R"({"Battery": {"Temperature": {"from": "battery.temperature"}}})"),
              (Bytes{0, 0, 0, 0, 0, 0, 0, 0}));
}

TEST_F(DbcValueOutput, SaturatesAtWhatTheBitsHold) {
    board_.set(kCurrent, 1e9, at(0));
    EXPECT_EQ(sent(R"({"Battery": {"Current": {"from": "battery.current"}}})"),
              (Bytes{0, 0, 0xFF, 0x7F, 0, 0, 0, 0}));
    board_.set(kCurrent, -1e9, at(0));
    EXPECT_EQ(sent(R"({"Battery": {"Current": {"from": "battery.current"}}})"),
              (Bytes{0, 0, 0x00, 0x80, 0, 0, 0, 0}));
}

TEST_F(DbcValueOutput, ANumberNeverComesOutAsTheCodeForNone) {
    board_.set(kCells, 1e9, at(0));
    EXPECT_EQ(sent(R"({"Battery": {"Cells": {"from": "cells", "not_available": 255}}})"),
              (Bytes{0, 0, 0, 0, 0, 0xFE, 0, 0}));
}

TEST_F(DbcValueOutput, AMissingNumberIsTheCodeForNone) {
    board_.remove(kVoltage);
    EXPECT_EQ(sent(R"({"Battery": {"Voltage": {"from": "battery.voltage", "not_available": 65535},
                                   "Cells": {"from": "cells"}}})"),
              (Bytes{0xFF, 0xFF, 0, 0, 0, 3, 0, 0}));
}

TEST_F(DbcValueOutput, WithoutACodeTheMessageOfAMissingNumberIsNotSent) {
    board_.remove(kVoltage);
    EXPECT_EQ(sent(R"({"Battery": {"Voltage": {"from": "battery.voltage"},
                                   "Cells": {"from": "cells"}}})"),
              std::nullopt);
    // Other messages are sent.
    EXPECT_EQ(sent(R"({"Battery": {"Voltage": {"from": "battery.voltage"}},
                       "Slow": {"Cells": {"from": "cells"}}})"),
              Bytes{3});
}

TEST_F(DbcValueOutput, NotANumberAndAnUnknownNameAreMissing) {
    board_.set(kCells, std::numeric_limits<double>::quiet_NaN(), at(0));
    EXPECT_EQ(sent(R"({"Battery": {"Cells": {"from": "cells"}}})"), std::nullopt);
    EXPECT_EQ(sent(R"({"Battery": {"Cells": {"from": "sheep"}}})"), std::nullopt);
}

TEST_F(DbcValueOutput, WithoutABoardAllNumbersAreMissing) {
    DbcEncoder encoder(dbc_map(dbc_settings(kBattery, R"({"Slow": {"Cells": {"from": "cells"}}})"),
                               SettingScope::output));
    EXPECT_EQ(frames_of(encoder, ChannelFrame{}, at(0)).size(), 0U);
}

TEST_F(DbcValueOutput, FallsSilentWhenANumberGrowsStaleAndComesBackAtOnceWithIt) {
    DbcEncoder encoder(
        dbc_map(dbc_settings(kBattery, R"({"Battery": {"Voltage": {"from": "battery.voltage"},
                                                       "Count": {"counter": true}}})",
                             R"({"Battery": "100ms"})"),
                SettingScope::output));
    encoder.use(board_);
    std::vector<std::pair<int, int>> sent;
    for (int now = 0; now <= 1000; now += 20) {
        if (now == 760) {
            board_.set(kVoltage, 12600, at(now));
        }
        for (const CanFrame& frame : frames_of(encoder, ChannelFrame{}, at(now))) {
            sent.emplace_back(now, frame.data[6]);
        }
    }
    // Stale after 500 ms. The counter goes on from its last value.
    EXPECT_EQ(sent, (std::vector<std::pair<int, int>>{{0, 0},
                                                      {100, 1},
                                                      {200, 2},
                                                      {300, 3},
                                                      {400, 4},
                                                      {500, 5},
                                                      {760, 6},
                                                      {860, 7},
                                                      {960, 8}}));
}

TEST_F(DbcValueOutput, TheChecksumIsOfTheValuesToo) {
    // 3 at byte 5; the exclusive or of all bytes except the last.
    EXPECT_EQ(sent(R"({"Battery": {"Cells": {"from": "cells"}, "Check": {"checksum": "xor"}}})"),
              (Bytes{0, 0, 0, 0, 0, 3, 0, 3}));
}

constexpr std::string_view kPages = R"(
BO_ 1 M: 2 A
 SG_ Page M : 0|8@1+ (1,0) [0|0] "" B
 SG_ Voltage m1 : 8|8@1+ (0.1,0) [0|0] "V" B
 SG_ Cells m2 : 8|8@1+ (1,0) [0|0] "" B
)";

TEST_F(DbcValueOutput, EachPageIsSentWithItsValuesWhileTheyAreThere) {
    DbcEncoder encoder(
        dbc_map(dbc_settings(kPages, R"({"M": {"Voltage": {"from": "battery.voltage"},
                                               "Cells": {"from": "cells"}}})"),
                SettingScope::output));
    encoder.use(board_);
    const CanFrames both = frames_of(encoder, ChannelFrame{}, at(0));
    ASSERT_EQ(both.size(), 2U);
    EXPECT_EQ(bytes_of(both[0]), (Bytes{1, 126}));
    EXPECT_EQ(bytes_of(both[1]), (Bytes{2, 3}));
    board_.remove(kVoltage);
    const CanFrames one = frames_of(encoder, ChannelFrame{}, at(20));
    ASSERT_EQ(one.size(), 1U);
    EXPECT_EQ(bytes_of(one[0]), (Bytes{2, 3}));
}

// J1939 electronic engine controller and a proprietary message, with the layout of SAE J1939-71.
const std::string kJ1939 = R"(
BO_ 2364540158 M: 8 A
 SG_ Wide : 0|16@1+ (0.05,0) [0|0] "V" B
 SG_ Byte : 16|8@1+ (1,-40) [0|0] "degC" B
 SG_ Two : 24|2@1+ (1,0) [0|0] "" B
 SG_ Ten : 26|10@1+ (1,0) [0|0] "" B
 SG_ Signed : 40|8@1- (1,0) [0|0] "" B
)" + j1939_frames({2364540158});

std::string j1939_text() {
    // The same from a source that may send: 0x0CF00400.
    std::string text = kJ1939;
    for (std::size_t found = 0; (found = text.find("2364540158")) != std::string::npos;) {
        text.replace(found, 10, "2364539904");
    }
    return text;
}

TEST_F(DbcValueOutput, InJ1939AMissingNumberIsAllOnesWithoutBeingAsked) {
    board_.remove(kVoltage);
    EXPECT_EQ(sent(R"({"M": {"Wide": {"from": "battery.voltage"}, "Byte": {"from": "cells"}}})",
                   j1939_text()),
              (Bytes{0xFF, 0xFF, 43, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF}));
    EXPECT_EQ(sent(R"({"M": {"Wide": {"from": "battery.voltage", "not_available": 65024}}})",
                   j1939_text()),
              (Bytes{0x00, 0xFE, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF}));
}

TEST_F(DbcValueOutput, InJ1939ASignedSignalHasNoCodeForAMissingNumber) {
    board_.remove(kVoltage);
    EXPECT_EQ(sent(R"({"M": {"Signed": {"from": "battery.voltage"}}})", j1939_text()),
              std::nullopt);
}

TEST_F(DbcValueOutput, InJ1939ANumberSaturatesBelowTheCodes) {
    board_.set(kCells, 1e9, at(0));
    EXPECT_EQ(
        sent(R"({"M": {"Wide": {"from": "cells"}, "Byte": {"from": "cells"}}})", j1939_text()),
        (Bytes{0xFF, 0xFA, 0xFA, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF}));
    // 2 bits: 0b01; 10 bits: 1021.
    EXPECT_EQ(sent(R"({"M": {"Two": {"from": "cells"}, "Ten": {"from": "cells"}}})", j1939_text()),
              (Bytes{0xFF, 0xFF, 0xFF, 0xF5, 0xFF, 0xFF, 0xFF, 0xFF}));
}

SettingValues output(std::string_view signals) {
    return dbc_settings(kBattery, signals);
}

TEST(DbcValueNames, AreThoseOfTheOutputWithTheKeysThatNameThem) {
    const auto uses =
        kDbcProtocol.value_names(output(R"({"Battery": {"Voltage": {"from": "battery.voltage"},
                               "Current": {"channel": 1, "value": [-100, 100]}},
                   "Slow": {"Cells": {"from": "cells"}}})"));
    ASSERT_EQ(uses.size(), 2U);
    EXPECT_EQ(uses[0].name, "battery.voltage");
    EXPECT_EQ(uses[0].path, (std::vector<std::string>{"signals", "Battery", "Voltage", "from"}));
    EXPECT_EQ(uses[0].unit, "V");
    EXPECT_EQ(uses[1].name, "cells");
    EXPECT_EQ(uses[1].unit, "");
    EXPECT_EQ(uses[1].path, (std::vector<std::string>{"signals", "Slow", "Cells", "from"}));
}

TEST(DbcValueOutputs, NeedNoPipelineUnlessTheyTellOfChannels) {
    EXPECT_FALSE(kDbcProtocol.needs_pipeline(
        output(R"({"Battery": {"Voltage": {"from": "battery.voltage"}, "Cells": {"fixed": 3},
                               "Count": {"counter": true}}})")));
    EXPECT_TRUE(
        kDbcProtocol.needs_pipeline(output(R"({"Battery": {"Voltage": {"from": "battery.voltage"},
                               "Cells": {"channel": 1, "value": [0, 200]}}})")));
    EXPECT_TRUE(
        kDbcProtocol.needs_pipeline(output(R"({"Battery": {"Voltage": {"from": "battery.voltage"},
                               "Cells": {"flag": "failsafe"}}})")));
}

TEST(DbcValueOutputs, KeepThePeriodOfTheProtocol) {
    EXPECT_EQ(kDbcProtocol.own_period(output(R"({"Slow": {"Cells": {"from": "cells"}}})")),
              std::nullopt);
}

std::vector<std::string> mistakes(std::string_view signals, SettingScope scope) {
    const auto map = build_dbc_map(output(signals), scope);
    return map ? std::vector<std::string>{} : told(map.error());
}

TEST(DbcValueMistakes, AnInputSendsNoValue) {
    EXPECT_EQ(
        mistakes(R"({"Battery": {"Voltage": {"from": "battery.voltage"}}})", SettingScope::input),
        (std::vector<std::string>{"signals.Battery.Voltage.from: \"from\" sends a named value, but "
                                  "this is an input; allowed: in the signals of an output; "
                                  "[values.NAME] makes named values of the signals of a message"}));
}

TEST(DbcValueMistakes, TheCodeMustFitAndTheNameBeText) {
    EXPECT_EQ(mistakes(R"({"Battery": {"Cells": {"from": "cells", "not_available": 256}}})",
                       SettingScope::output),
              (std::vector<std::string>{
                  "signals.Battery.Cells.not_available: 256 does not fit the 8 bits of "
                  "\"Cells\"; allowed: a raw value that does"}));
    EXPECT_EQ(mistakes(R"({"Battery": {"Cells": {"from": 3, "error": 1}}})", SettingScope::output),
              (std::vector<std::string>{
                  "signals.Battery.Cells.from: \"from\" has a wrong value; allowed: the name "
                  "of a value, such as \"cells\"",
                  "signals.Battery.Cells.error: unknown key \"error\"; allowed here: \"from\", "
                  "\"not_available\""}));
}

}  // namespace
}  // namespace tribus::value_test
