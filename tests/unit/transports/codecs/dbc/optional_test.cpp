#include <gtest/gtest.h>

#include <array>
#include <string>
#include <string_view>

#include "tests/support/dbc_maps.h"
#include "transports/codecs/dbc/dbc.h"

/// Messages of which nothing or all is optional, and how long a fault is named.
namespace tribus::test::optional_test {
namespace {

constexpr std::string_view kDbc = R"(BO_ 1 Sticks: 2 A
 SG_ Steer : 0|16@1+ (1,0) [800|2200] "us" B
BO_ 2 Buttons: 1 A
 SG_ Horn : 0|8@1+ (1,0) [0|10] "" B
BO_ 3 Checked: 2 A
 SG_ Gas : 0|8@1+ (1,0) [0|100] "" B
 SG_ Sum : 8|8@1+ (1,0) [0|255] "" B
)";
constexpr std::string_view kHorn = R"({"Horn": {"channel": 2, "optional": true}})";

DbcDecoder decoder_of(const std::string& signals) {
    return DbcDecoder(dbc_map(dbc_settings(kDbc, signals, {}), SettingScope::input));
}

const CanFrame kCentred = standard_frame(1, {0xDC, 0x05});
const CanFrame kPressed = standard_frame(2, {10});

/// Neither message has a cycle in the file.
TEST(OptionalSignals, HoldUpNoOthersIfTheirMessageStops) {
    DbcDecoder decoder =
        decoder_of(R"({"Sticks": {"Steer": 1}, "Buttons": )" + std::string(kHorn) + "}");
    decoder.next(kPressed, at(0));
    const auto with = decoder.next(kCentred, at(10));
    ASSERT_TRUE(with);
    EXPECT_TRUE(with->has(1));
    for (int time = 20; time <= 1000; time += 20) {
        const auto snapshot = decoder.next(kCentred, at(time));
        ASSERT_TRUE(snapshot) << time;
        EXPECT_TRUE(snapshot->good()) << time;
        EXPECT_EQ(snapshot->has(1), time <= 500) << time;
    }
}

TEST(OptionalSignals, AreAwaitedWhereThereAreNoOthers) {
    DbcDecoder decoder = decoder_of(R"({"Buttons": )" + std::string(kHorn) + "}");
    EXPECT_TRUE(decoder.next(kPressed, at(0)));
    EXPECT_TRUE(decoder.next(kPressed, at(20)));
}

std::string fault_of(const DbcDecoder& decoder) {
    std::array<char, 200> text{};
    return {text.data(), decoder.write_fault(text)};
}

TEST(DbcFault, InAValueIsForgottenWhenTheFramesAreRefusedForAnotherReason) {
    DbcDecoder decoder = decoder_of(R"({"Checked": {"Gas": 1, "Sum": {"checksum": "sum"}}})");
    const CanFrame far = standard_frame(3, {200, 200});
    const CanFrame wrong_sum = standard_frame(3, {50, 1});
    decoder.next(far, at(0));
    EXPECT_EQ(fault_of(decoder), "message Checked, signal Gas: 200 is outside of [0|100]");
    decoder.next(wrong_sum, at(20));
    EXPECT_NE(fault_of(decoder), "") << "one frame may be noise";
    decoder.next(wrong_sum, at(600));
    EXPECT_EQ(fault_of(decoder), "");
}

/// 255 x 0.4 % would be 102 %, more than full travel, and the file has no range against it.
TEST(J1939Channel, AllBitsSetIsNoValueAndIsNeverSentAsOne) {
    const auto map = [](SettingScope scope) {
        return dbc_map(
            dbc_settings("BO_ 2365512755 J: 1 A\n SG_ Throttle : 0|8@1+ (0.4,0) [0|0] \"%\" B\n" +
                             j1939_frames({2365512755}),
                         R"({"J": {"Throttle": {"channel": 1, "value": [0, 102]}}})", {}),
            scope);
    };
    const std::uint32_t id = 2365512755U & 0x1FFFFFFFU;
    DbcDecoder decoder(map(SettingScope::input));
    const auto full = decoder.next(extended_frame(id, {0xFA}), at(0));
    ASSERT_TRUE(full);
    EXPECT_TRUE(full->good());
    const auto none = decoder.next(extended_frame(id, {0xFF}), at(20));
    ASSERT_TRUE(none);
    EXPECT_TRUE(none->failsafe);
    EXPECT_FALSE(none->has(0));

    DbcEncoder encoder(map(SettingScope::output));
    ChannelFrame most;
    most.set(0, Pulse::from_microseconds(2000));
    const CanFrames sent = frames_of(encoder, most, at(0));
    ASSERT_EQ(sent.size(), 1U);
    EXPECT_EQ(sent[0].data[0], 0xFE);
}

/// A name of any length leaves room for the value.
TEST(DbcFault, NamesAreCutNotTheValue) {
    const std::string name(150, 'x');
    DbcDecoder decoder(dbc_map(
        dbc_settings("BO_ 1 M: 2 A\n SG_ " + name + " : 0|16@1+ (1,0) [800|2200] \"us\" B\n",
                     R"({"M": {")" + name + R"(": 1}})", {}),
        SettingScope::input));
    decoder.next(standard_frame(1, {0xB8, 0x0B}), at(0));
    EXPECT_EQ(fault_of(decoder),
              "message M, signal " + std::string(40, 'x') + ": 3000 is outside of [800|2200]");
}

}  // namespace
}  // namespace tribus::test::optional_test
