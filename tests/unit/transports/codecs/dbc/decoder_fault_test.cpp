#include <gtest/gtest.h>

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/dbc_maps.h"
#include "transports/codecs/dbc/dbc.h"

/// What a decoder says of frames that do not count.
namespace tribus::decoder_fault_test {
namespace {

using namespace test;

const std::string kFaulty = R"(BO_ 1 M: 8 A
 SG_ Steer : 0|16@1+ (1,0) [800|2200] "us" B
 SG_ Mode : 16|8@1+ (1,0) [0|10] "" B
 SG_ Float : 32|32@1- (1,0) [0|0] "" B
BO_ 2 Beat: 1 A
 SG_ State : 0|8@1+ (1,0) [0|10] "" B
BO_ 2365512755 J: 2 A
 SG_ Throttle : 0|16@1+ (0.0025,0) [0|160.6375] "%" B
SIG_VALTYPE_ 1 Float : 1;
)" + j1939_frames({2365512755});

std::string fault_of(const DbcDecoder& decoder) {
    std::array<char, 200> text{};
    return {text.data(), decoder.write_fault(text)};
}

/// What the decoder says of the frames, which come every 20 ms.
std::string fault_after(std::string_view signals, const std::vector<CanFrame>& frames) {
    DbcDecoder decoder(received_map(kFaulty, signals));
    int time = 0;
    for (const CanFrame& frame : frames) {
        decoder.next(frame, at(time += 20));
    }
    return fault_of(decoder);
}

TEST(DbcDecoder, NamesTheSignalWithoutAValue) {
    // 3000 is 0x0BB8.
    const CanFrame far = standard_frame(1, {0xB8, 0x0B, 5, 0, 0, 0, 0, 0});
    EXPECT_EQ(fault_after(R"({"M": {"Steer": 1}})", {far}),
              "message M, signal Steer: 3000 is outside of [800|2200]");
    EXPECT_EQ(fault_after(R"({"M": {"Steer": {"channel": 1, "not_available": 3000}}})", {far}),
              "message M, signal Steer: its code for \"not available\"");
    EXPECT_EQ(fault_after(R"({"M": {"Steer": {"channel": 1, "error": 3000}}})", {far}),
              "message M, signal Steer: its code for \"error\"");
    EXPECT_EQ(fault_after(R"({"M": {"Mode": {"fixed": 7}, "Steer": 1}})",
                          {standard_frame(1, {0xDC, 0x05, 5, 0, 0, 0, 0, 0})}),
              "message M, signal Mode: 5 came, but it is fixed to 7");
    EXPECT_EQ(fault_after(R"({"M": {"Steer": {"channel": 1, "optional": true}}})", {far}), "");
}

TEST(DbcDecoder, NamesTheSignalThatIsNoNumber) {
    const std::string_view use =
        R"({"M": {"Float": {"channel": 1, "value": [-1, 1], "us": [1000, 2000]}}})";
    EXPECT_EQ(fault_after(use, {standard_frame(1, {0, 0, 0, 0, 0, 0, 0xC0, 0x7F})}),
              "message M, signal Float: nan is no number");
    EXPECT_EQ(fault_after(use, {standard_frame(1, {0, 0, 0, 0, 0, 0, 0x80, 0xFF})}),
              "message M, signal Float: -inf is no number");
}

TEST(DbcDecoder, NamesNotAvailableOfJ1939WithoutAKeyForIt) {
    EXPECT_EQ(fault_after(R"({"J": {"Throttle": 1}})",
                          {extended_frame(2365512755U & 0x1FFFFFFFU, {0xFF, 0xFF})}),
              "message J, signal Throttle: its code for \"not available\"");
}

TEST(DbcDecoder, NamesTheByteThatAShortFrameLacks) {
    // The frame of captures/field/f10_short.log.
    EXPECT_EQ(
        fault_after(R"({"M": {"Steer": 1}})", {standard_frame(1, {0xF4, 0x01, 0, 0, 0, 0, 0})}),
        "message M: a frame has 7 bytes, but the DBC file gives it 8; signal Steer needs "
        "byte 2");
}

TEST(DbcDecoder, NamesTheMessageThatStaysAway) {
    DbcDecoder decoder(
        received_map(kFaulty, R"({"M": {"Steer": 1}, "Beat": {"State": {"fixed": 5}}})"));
    const CanFrame good = standard_frame(1, {0xDC, 0x05, 0, 0, 0, 0, 0, 0});
    decoder.next(standard_frame(2, {5}), at(0));
    decoder.next(good, at(10));
    EXPECT_EQ(fault_of(decoder), "");
    decoder.next(good, at(600));
    EXPECT_EQ(fault_of(decoder), "message Beat: it has not come for 500 ms");
    decoder.next(standard_frame(2, {5}), at(610));
    decoder.next(good, at(620));
    EXPECT_EQ(fault_of(decoder), "");
}

TEST(DbcDecoder, SaysNothingOfASenderThatSaysFailsafeItself) {
    const std::string_view use = R"({"M": {"Steer": 1, "Mode": {"flag": "failsafe"}}})";
    EXPECT_EQ(fault_after(use, {standard_frame(1, {0xFF, 0xFF, 1, 0, 0, 0, 0, 0})}), "");
}

TEST(DbcDecoder, CutsTheFaultToTheRoomForIt) {
    DbcDecoder decoder(received_map(kFaulty, R"({"M": {"Steer": 1}})"));
    decoder.next(standard_frame(1, {0xB8, 0x0B, 5, 0, 0, 0, 0, 0}), at(0));
    std::array<char, 12> text{};
    EXPECT_EQ(std::string(text.data(), decoder.write_fault(text)), "message M, s");
    EXPECT_EQ(decoder.write_fault({}), 0U);
}

}  // namespace
}  // namespace tribus::decoder_fault_test
