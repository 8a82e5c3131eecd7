#include "transports/codecs/dbc/value_reader.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/dbc_maps.h"

namespace tribus::value_reader_test {
namespace {

using namespace test;
using State = ValueReading::State;

/// A reader and its last result.
class Reader {
  public:
    explicit Reader(std::string_view dbc, std::string_view message = "M")
        : reader_(*make_dbc_value_reader(*parse_dbc(dbc), message)),
          readings_(reader_.values().size()) {}

    DbcValueReader* operator->() { return &reader_; }
    bool take(const CanFrame& frame) {
        return reader_.take(frame, Instant{}, readings_).has_value();
    }
    /// Returns the number of a signal in this frame, or nothing if it has none.
    std::optional<double> number(const CanFrame& frame, std::size_t signal = 0) {
        EXPECT_TRUE(take(frame));
        return readings_.at(signal).state == State::number ? std::optional(readings_[signal].number)
                                                           : std::nullopt;
    }
    State state(std::size_t signal) const { return readings_.at(signal).state; }

  private:
    DbcValueReader reader_;
    std::vector<ValueReading> readings_;
};

constexpr std::string_view kBattery = R"(
BO_ 256 M: 6 A
 SG_ Voltage : 0|16@1+ (0.01,0) [0|60] "V" B
 SG_ Current : 23|16@0- (0.1,0) [0|0] "A" B
 SG_ Temperature : 32|8@1+ (1,-40) [0|0] "degC" B
BO_ 257 Other: 1 A
 SG_ Cells : 0|8@1+ (1,0) [0|0] "" B
BA_DEF_ BO_ "GenMsgCycleTime" INT 0 60000;
BA_ "GenMsgCycleTime" BO_ 256 100;
)";

TEST(DbcValueReader, TellsTheSignalsOfTheMessageInTheOrderOfTheFile) {
    Reader reader(kBattery);
    ASSERT_EQ(reader->values().size(), 3U);
    EXPECT_EQ(reader->values()[0].name, "Voltage");
    EXPECT_EQ(reader->values()[0].unit, "V");
    EXPECT_EQ(reader->values()[2].name, "Temperature");
    EXPECT_EQ(reader->cycle_time(), milliseconds(100));
    EXPECT_FALSE(reader->uses_fd());
    ASSERT_EQ(reader->wanted().size(), 1U);
    EXPECT_EQ(reader->wanted()[0], (CanIdMatch{.id = 256}));
    EXPECT_EQ(Reader(kBattery, "Other")->cycle_time(), std::nullopt);
}

TEST(DbcValueReader, ReadsPhysicalNumbers) {
    Reader reader(kBattery);
    // 0x04EC = 1260, low byte first; 0xFFE7 = -25, high byte first; 0x41 = 65.
    const CanFrame frame = standard_frame(256, {0xEC, 0x04, 0xFF, 0xE7, 0x41, 0});
    EXPECT_DOUBLE_EQ(reader.number(frame, 0).value_or(0), 12.6);
    EXPECT_DOUBLE_EQ(reader.number(frame, 1).value_or(0), -2.5);
    EXPECT_DOUBLE_EQ(reader.number(frame, 2).value_or(0), 25);
}

TEST(DbcValueReader, BeyondTheRangeOfTheFileIsNoNumber) {
    Reader reader(kBattery);
    // 6000 is 60 V, 6001 is more.
    EXPECT_EQ(reader.number(standard_frame(256, {0x70, 0x17, 0, 0, 0, 0})), 60);
    EXPECT_EQ(reader.number(standard_frame(256, {0x71, 0x17, 0, 0, 0, 0})), std::nullopt);
    EXPECT_EQ(reader.state(0), State::not_available);
    EXPECT_EQ(reader.state(1), State::number);
}

TEST(DbcValueReader, PassesOtherMessagesOver) {
    Reader reader(kBattery);
    EXPECT_FALSE(reader.take(standard_frame(257, {0, 0, 0, 0, 0, 0})));
    EXPECT_FALSE(reader.take(extended_frame(256, {0, 0, 0, 0, 0, 0})));
    EXPECT_EQ(reader->rejected()[0].count + reader->rejected()[1].count, 0U);
}

TEST(DbcValueReader, RefusesAndCountsWhatIsNoSuchFrame) {
    Reader reader(kBattery);
    EXPECT_FALSE(reader.take(standard_frame(256, {0, 0, 0, 0, 0})));
    CanFrame fd = standard_frame(256, {0, 0, 0, 0, 0, 0});
    fd.fd = true;
    EXPECT_FALSE(reader.take(fd));
    CanFrame remote = standard_frame(256, {0, 0, 0, 0, 0, 0});
    remote.remote = true;
    EXPECT_FALSE(reader.take(remote));
    EXPECT_EQ(reader->rejected()[0].name, "length");
    EXPECT_EQ(reader->rejected()[0].count, 2U);
    EXPECT_EQ(reader->rejected()[1].name, "remote");
    EXPECT_EQ(reader->rejected()[1].count, 1U);
}

TEST(DbcValueReader, ALongerFrameHasTheSignalsToo) {
    Reader reader(kBattery);
    EXPECT_EQ(reader.number(standard_frame(256, {0x64, 0, 0, 0, 0, 0, 0xFF, 0xFF})), 1);
}

TEST(DbcValueReader, ASignalOfAnotherPageIsAbsent) {
    Reader reader(R"(
BO_ 1 M: 2 A
 SG_ Page M : 0|8@1+ (1,0) [0|0] "" B
 SG_ One m1 : 8|8@1+ (1,0) [0|0] "" B
 SG_ Two m2 : 8|8@1+ (2,0) [0|0] "" B
)");
    EXPECT_EQ(reader.number(standard_frame(1, {1, 5}), 1), 5);
    EXPECT_EQ(reader.state(2), State::absent);
    EXPECT_EQ(reader.number(standard_frame(1, {2, 5}), 2), 10);
    EXPECT_EQ(reader.state(1), State::absent);
}

TEST(DbcValueReader, AFloatThatIsNotFiniteIsNoNumber) {
    Reader reader(R"(
BO_ 1 M: 4 A
 SG_ Float : 0|32@1- (1,0) [0|0] "" B
SIG_VALTYPE_ 1 Float : 1;
)");
    EXPECT_EQ(reader.number(standard_frame(1, {0, 0, 0xC0, 0x3F})), 1.5);
    EXPECT_EQ(reader.number(standard_frame(1, {0, 0, 0xC0, 0x7F})), std::nullopt);
    EXPECT_EQ(reader.number(standard_frame(1, {0, 0, 0x80, 0xFF})), std::nullopt);
}

// 0x0CF004FE: parameter group 0xF004 from any source.
const std::string kJ1939 = R"(
BO_ 2364540158 M: 8 A
 SG_ Two : 0|2@1+ (1,0) [0|0] "" B
 SG_ Ten : 2|10@1+ (1,0) [0|0] "" B
 SG_ Byte : 16|8@1+ (1,-40) [0|0] "degC" B
 SG_ Wide : 24|16@1+ (0.125,0) [0|0] "rpm" B
 SG_ Signed : 40|8@1- (1,0) [0|0] "" B
 SG_ Bit : 48|1@1+ (1,0) [0|0] "" B
)" + j1939_frames({2364540158});

TEST(DbcValueReader, AJ1939MessageIsItsParameterGroup) {
    Reader reader(kJ1939);
    EXPECT_TRUE(reader.take(extended_frame(0x0CF00400, std::vector<std::uint8_t>(8))));
    EXPECT_TRUE(reader.take(extended_frame(0x18F00421, std::vector<std::uint8_t>(8))));
    EXPECT_FALSE(reader.take(extended_frame(0x0CF00500, std::vector<std::uint8_t>(8))));
}

/// Returns a frame whose bits are ones except those of one signal.
CanFrame j1939_frame(unsigned first_bit, unsigned bits, std::uint64_t raw) {
    const std::uint64_t own = ((std::uint64_t{1} << bits) - 1) << first_bit;
    const std::uint64_t all = ~own | raw << first_bit;
    std::vector<std::uint8_t> data;
    for (unsigned byte = 0; byte < 8; ++byte) {
        data.push_back(static_cast<std::uint8_t>(all >> (8 * byte)));
    }
    return extended_frame(0x0CF00400, data);
}

// SAE J1939-71: a highest byte of 0xFB or more is no number. In 2 bits 0b10 and 0b11, and in the 10
// bits of a joystick 1022 and 1023, mean "error" and "not available".
TEST(DbcValueReader, TheCodesOfJ1939AreNoNumbers) {
    Reader reader(kJ1939);
    EXPECT_EQ(reader.number(j1939_frame(0, 2, 1), 0), 1);
    EXPECT_EQ(reader.number(j1939_frame(0, 2, 2), 0), std::nullopt);
    EXPECT_EQ(reader.number(j1939_frame(0, 2, 3), 0), std::nullopt);
    EXPECT_EQ(reader.number(j1939_frame(2, 10, 1021), 1), 1021);
    EXPECT_EQ(reader.number(j1939_frame(2, 10, 1022), 1), std::nullopt);
    EXPECT_EQ(reader.number(j1939_frame(16, 8, 0xFA), 2), 210);
    EXPECT_EQ(reader.number(j1939_frame(16, 8, 0xFB), 2), std::nullopt);
    EXPECT_EQ(reader.number(j1939_frame(24, 16, 0xFAFF), 3), 0xFAFF * 0.125);
    EXPECT_EQ(reader.number(j1939_frame(24, 16, 0xFB00), 3), std::nullopt);
}

TEST(DbcValueReader, SignedSignalsAndSingleBitsHaveNoCodesInJ1939) {
    Reader reader(kJ1939);
    EXPECT_EQ(reader.number(j1939_frame(40, 8, 0xFF), 4), -1);
    EXPECT_EQ(reader.number(j1939_frame(48, 1, 1), 5), 1);
}

TEST(DbcValueReader, WithoutJ1939AllOnesAreANumber) {
    Reader reader(kBattery);
    EXPECT_EQ(reader.number(standard_frame(256, {0, 0, 0, 0, 0xFF, 0}), 2), 215);
}

TEST(DbcValueReader, NamesTheMessagesThatThereAre) {
    const auto reader = make_dbc_value_reader(*parse_dbc(kBattery), "Batery");
    ASSERT_FALSE(reader);
    EXPECT_EQ(reader.error(), "the DBC file has no message \"Batery\"; allowed: \"M\", \"Other\"");
}

}  // namespace
}  // namespace tribus::value_reader_test
