#include <cmath>
#include <cstddef>
#include <cstdint>
#include <tuple>

#include <gtest/gtest.h>

#include "tests/support/streams.h"
#include "transports/codecs/dronecan/payload.h"
#include "transports/codecs/dronecan/types.h"

/// What is refused, what is saturated, and where lengths of arrays are. The vectors
/// (tests/captures/dronecan_types_test.cpp) cover payloads that are sent correctly.
namespace tribus::dronecan::payload_test {
namespace {

using test::Bytes;
using test::from_hex;

constexpr bool kClassic = false;
constexpr bool kFd = true;

template <class T>
Bytes written(const T& value, bool fd) {
    const auto payload = write(value, fd);
    return {payload.begin(), payload.end()};
}

/// The types with which the specification explains the rules ("Dynamic arrays").
struct WithLength {  // root.A
    std::uint8_t foo = 0;
    BoundedArray<std::uint8_t, 8> array;
    static constexpr auto fields() {
        return std::tuple(field<Unsigned<8>>("foo", &WithLength::foo),
                          field<ArrayOf<Unsigned<8>>>("array", &WithLength::array));
    }
};
struct ArrayOfThose {  // root.Z
    BoundedArray<WithLength, 2> array;
    static constexpr auto fields() {
        return std::tuple(field<ArrayOf<Nested>>("array", &ArrayOfThose::array));
    }
};
struct WithNibble {  // root.Q
    std::uint8_t fooz = 0;
    BoundedArray<std::uint8_t, 64> array;
    static constexpr auto fields() {
        return std::tuple(field<Unsigned<4>>("fooz", &WithNibble::fooz),
                          field<ArrayOf<Unsigned<8>>>("array", &WithNibble::array));
    }
};
struct ArrayOfNibbles {  // root.X
    BoundedArray<WithNibble, 12> array;
    static constexpr auto fields() {
        return std::tuple(field<ArrayOf<Nested>>("array", &ArrayOfNibbles::array));
    }
};
struct TruncatedBits {
    std::uint8_t kept = 0;
    std::uint8_t cut = 0;
    static constexpr auto fields() {
        return std::tuple(field<Unsigned<4>>("kept", &TruncatedBits::kept),
                          field<Unsigned<4, Cast::truncated>>("cut", &TruncatedBits::cut));
    }
};

TEST(DroneCanPayload, TheLastArrayHasNoLengthButTheArraysInsideItsItemsHave) {
    ArrayOfThose value;
    value.array = {{.foo = 0xAA, .array = {1}}, {.foo = 0xBB, .array = {2, 3}}};
    // Items of 8 bits, 4 bits of length each: AA 1 01 | BB 2 02 03.
    EXPECT_EQ(written(value, kClassic), from_hex("AA 10 1B B2 02 03"));
    // On FD there are 2 bits of length before them: 10 10101010 0001 ...
    EXPECT_EQ(written(value, kFd), from_hex("AA 84 06 EC 80 80 C0"));
    for (const bool fd : {kClassic, kFd}) {
        const auto back = read<ArrayOfThose>(written(value, fd), fd);
        ASSERT_TRUE(back);
        ASSERT_EQ(back->array.size(), 2U);
        EXPECT_EQ(back->array[0].array, value.array[0].array);
        EXPECT_EQ(back->array[1].array, value.array[1].array);
    }
}

TEST(DroneCanPayload, AnArrayOfShortItemsHasItsLengthButTheLastArrayInItHasNone) {
    ArrayOfNibbles value;
    value.array = {{.fooz = 0x5, .array = {0x11}}, {.fooz = 0x6, .array = {0x22, 0x33}}};
    // 4 bits of length; 0x5, 7 bits of length, 0x11; 0x6, 0x22, 0x33 up to the end of the payload:
    // 0010 0101 0000001 00010001 0110 00100010 00110011
    EXPECT_EQ(written(value, kClassic), from_hex("25 02 22 C4 46 60"));
    const auto back = read<ArrayOfNibbles>(from_hex("25 02 22 C4 46 60"), kClassic);
    ASSERT_TRUE(back);
    ASSERT_EQ(back->array.size(), 2U);
    EXPECT_EQ(back->array[1].array, (BoundedArray<std::uint8_t, 64>{0x22, 0x33}));
}

TEST(DroneCanPayload, OnClassicCanNothingIsTooMany) {
    // RCInput: 28 bits plus 12 bits for each channel.
    for (std::size_t bytes = 0; bytes <= 60; ++bytes) {
        const std::size_t channels = bytes < 4 ? 0 : (bytes * 8 - 28) / 12;
        const bool fits = bytes >= 4 && channels <= 32 && (28 + channels * 12 + 7) / 8 == bytes;
        const auto value = read<RcInput>(Bytes(bytes), kClassic);
        ASSERT_EQ(value.has_value(), fits) << bytes;
        if (fits) {
            EXPECT_EQ(value->rcin.size(), channels);
        }
    }
    EXPECT_FALSE(read<NodeStatus>(Bytes(6), kClassic));
    EXPECT_TRUE(read<NodeStatus>(Bytes(7), kClassic));
    EXPECT_FALSE(read<NodeStatus>(Bytes(8), kClassic));
    EXPECT_TRUE(read<GetNodeInfo::Request>(Bytes{}, kClassic));
    EXPECT_FALSE(read<GetNodeInfo::Request>(Bytes(1), kClassic));
}

TEST(DroneCanPayload, OnFdZerosMayFollowButNothingMayBeMissing) {
    RcInput expected;
    expected.status = RcInput::kQualityValid;
    expected.quality = 255;
    expected.id = 15;
    expected.rcin = {4095, 0};
    Bytes payload = written(expected, kFd);
    EXPECT_EQ(payload.size(), 8U);  // 16 + 8 + 4 + 6 + 2 * 12 bits
    for (int padding = 0; padding < 16; ++padding) {
        EXPECT_EQ(read<RcInput>(payload, kFd), expected);
        payload.push_back(0);
    }
    payload.resize(7);
    EXPECT_FALSE(read<RcInput>(payload, kFd));
}

TEST(DroneCanPayload, AnArrayLongerThanItsTypeIsRefused) {
    // 28 bits, then 6 bits of length, at most 32: 0000 1000 01.. is 33.
    Bytes payload(60);
    payload[3] = 0x08;
    payload[4] = 0x00;
    ASSERT_TRUE(read<RcInput>(payload, kFd));
    EXPECT_EQ(read<RcInput>(payload, kFd)->rcin.size(), 32U);
    payload[4] = 0x40;
    EXPECT_FALSE(read<RcInput>(payload, kFd));
}

TEST(DroneCanPayload, AnUnknownAlternativeIsRefused) {
    Bytes payload = from_hex("00 04 00");  // 13 bits of index, alternative 4: a text of 0 letters
    ASSERT_TRUE(read<ParamGetSet::Request>(payload, kClassic));
    EXPECT_EQ(read<ParamGetSet::Request>(payload, kClassic)->value.held.index(), 4U);
    payload[1] = 0x05;
    EXPECT_FALSE(read<ParamGetSet::Request>(payload, kClassic));
}

TEST(DroneCanPayload, PaddingMayBeAnythingAndIsSentAsZero) {
    // The alternative "empty" four times: 5, 5, 6 and 6 bits of padding before 3, 3, 2 and 2 bits
    // of tag.
    const auto value = read<ParamGetSet::Response>(from_hex("F8 F8 FC FC"), kClassic);
    ASSERT_TRUE(value);
    EXPECT_EQ(*value, ParamGetSet::Response{});
    EXPECT_EQ(written(*value, kClassic), from_hex("00 00 00 00"));
}

TEST(DroneCanPayload, ValuesTooLargeAreSaturated) {
    RcInput channels;
    channels.id = 200;
    channels.rcin = {4096, 65535, 4095};
    const auto read_channels = read<RcInput>(written(channels, kClassic), kClassic);
    ASSERT_TRUE(read_channels);
    EXPECT_EQ(read_channels->id, 15);
    EXPECT_EQ(read_channels->rcin, (BoundedArray<std::uint16_t, 32>{4095, 4095, 4095}));

    EscRawCommand command;
    command.cmd = {8192, 32767, -8193, -32768, 8191, -8192, -1};
    const auto read_command = read<EscRawCommand>(written(command, kClassic), kClassic);
    ASSERT_TRUE(read_command);
    EXPECT_EQ(read_command->cmd,
              (BoundedArray<std::int16_t, 20>{8191, 8191, -8192, -8192, 8191, -8192, -1}));
}

TEST(DroneCanPayload, WhatIsDeclaredTruncatedLosesItsHighBits) {
    EXPECT_EQ(written(TruncatedBits{.kept = 0x44, .cut = 0x44}, kClassic), from_hex("F4"));
}

TEST(DroneCanPayload, AnyNotANumberIsUnknown) {
    // As libcanard sends it, as most others do, negative, signalling.
    for (const char* unknown : {"FF 7F", "00 7E", "00 FE", "01 7C"}) {
        Bytes payload = from_hex("01 00");
        test::append(payload, from_hex(unknown));
        const auto value = read<ArrayCommand>(payload, kClassic);
        ASSERT_TRUE(value);
        EXPECT_TRUE(std::isnan(value->commands[0].command_value)) << unknown;
        EXPECT_EQ(written(*value, kClassic), from_hex("01 00 00 7E"));
    }
}

/// Maximum lengths of generated headers of other implementations (..._MAX_SIZE). RCInput:
/// docs/protocols/can.md, "DroneCAN: RCInput".
TEST(DroneCanPayload, TheLongestIsKnown) {
    EXPECT_EQ(bit_range<RcInput>().most, 418U);
    EXPECT_EQ(kMostBytes<NodeStatus>, 7U);
    EXPECT_EQ(kMostBytes<GetNodeInfo::Response>, 377U);
    EXPECT_EQ(kMostBytes<GetTransportStats::Response>, 73U);
    EXPECT_EQ(kMostBytes<EscStatusExtended>, 7U);
    EXPECT_EQ(kMostBytes<LogMessage>, 123U);
    EXPECT_EQ(kMostBytes<KeyValue>, 63U);
    EXPECT_EQ(kMostBytes<NotifyState>, 265U);
    EXPECT_EQ(kMostBytes<BatteryCells>, 51U);
    EXPECT_EQ(kMostBytes<CircuitStatus>, 7U);
    EXPECT_EQ(kMostBytes<FuelTankStatus>, 13U);
    EXPECT_EQ(kMostBytes<GnssFix2>, 222U);
    EXPECT_EQ(kMostBytes<BatteryInfoAux>, 528U);
    EXPECT_EQ(kMostBytes<ParamGetSet::Response>, 371U);
    EXPECT_EQ(kMostBytes<GetNodeInfo::Request>, 0U);
}

}  // namespace
}  // namespace tribus::dronecan::payload_test
