#include "transports/codecs/ibus_sensor/ibus_sensor.h"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "tests/support/sensor_wire.h"

namespace tribus::ibus_sensor_test {
namespace {

using namespace std::chrono_literals;

// The literal frames are those of docs/protocols/ibus.md, "Vectors", recorded from a real receiver.
TEST(IbusSensorFrame, RequestsAreWrittenAsAReceiverSendsThem) {
    EXPECT_EQ(encoded(SensorCommand::discover, 1), (Bytes{0x04, 0x81, 0x7A, 0xFF}));
    EXPECT_EQ(encoded(SensorCommand::type, 1), (Bytes{0x04, 0x91, 0x6A, 0xFF}));
    EXPECT_EQ(encoded(SensorCommand::value, 1), (Bytes{0x04, 0xA1, 0x5A, 0xFF}));
    EXPECT_EQ(encoded(SensorCommand::discover, 2), (Bytes{0x04, 0x82, 0x79, 0xFF}));
    EXPECT_EQ(encoded(SensorCommand::power_up, 0), (Bytes{0x04, 0xF0, 0x0B, 0xFF}));
}

TEST(IbusSensorFrame, RepliesAreWrittenAsSensorsSendThem) {
    EXPECT_EQ(encoded(SensorCommand::value, 1, {0x00, 0x00}),
              (Bytes{0x06, 0xA1, 0x00, 0x00, 0x58, 0xFF}));
    EXPECT_EQ(encoded(SensorCommand::value, 2, {0xFE, 0xFF}),
              (Bytes{0x06, 0xA2, 0xFE, 0xFF, 0x5A, 0xFD}));
}

TEST(SensorFrameParser, ReadsARequest) {
    SensorFrameParser parser;
    std::span<const std::uint8_t> bytes(kRequest);
    const auto frame = parser.next(bytes, Instant{});
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->command, SensorCommand::value);
    EXPECT_EQ(frame->address, 1);
    EXPECT_TRUE(frame->is_request());
    EXPECT_TRUE(bytes.empty());
}

TEST(SensorFrameParser, ReadsTheDataOfAReplyAndWhereItBegins) {
    SensorFrameParser parser;
    const Bytes wire = joined({kRequest, {0x06, 0xA2, 0xFE, 0xFF, 0x5A, 0xFD}});
    std::span<const std::uint8_t> bytes(wire);
    ASSERT_TRUE(parser.next(bytes, Instant{}));
    const auto frame = parser.next(bytes, Instant{});
    ASSERT_TRUE(frame);
    const auto payload = frame->payload();
    EXPECT_EQ(Bytes(payload.begin(), payload.end()), (Bytes{0xFE, 0xFF}));
    EXPECT_EQ(frame->first_byte, 4U);
    EXPECT_FALSE(parser.next(bytes, Instant{}));
}

TEST(SensorFrameParser, ReadsThePowerUpFrame) {
    EXPECT_EQ(wire_of({0x04, 0xF0, 0x0B, 0xFF}).frames(),
              (std::vector<Bytes>{{0x04, 0xF0, 0x0B, 0xFF}}));
}

RC_GTEST_PROP(SensorFrameParser, EveryFrameOfAnyValueSizeComesBackWithItsLastByte, ()) {
    const auto address = *rc::gen::inRange<std::uint8_t>(1, 16);
    const auto size = *rc::gen::inRange<std::size_t>(0, kMostSensorData + 1);
    const auto data = *rc::gen::container<Bytes>(size, rc::gen::arbitrary<std::uint8_t>());
    const Bytes frame = encoded(SensorCommand::value, address, data);
    SensorFrameParser parser;
    const auto found = wire_of(frame).read(parser);
    RC_ASSERT(found.size() == 1U);
    RC_ASSERT(found.front().frame == frame);
    RC_ASSERT(found.front().bytes_read == frame.size());
    RC_ASSERT(parser.skipped_bytes() == 0U);
}

RC_GTEST_PROP(SensorFrameParser, ARequestBehindAnyNoiseIsFoundWithItsLastByteAfterAPause, ()) {
    Wire wire = wire_of(*rc::gen::arbitrary<Bytes>());
    wire.pause(4ms);
    wire.add(kRequest);
    SensorFrameParser parser;
    const auto found = wire.read(parser);
    RC_ASSERT(!found.empty());
    RC_ASSERT(found.back().frame == kRequest);
    RC_ASSERT(found.back().bytes_read == wire.size());
}

// 12 A1 begins a value of 14 bytes.
TEST(SensorFrameParser, ARequestRightBehindNoiseIsFoundWithItsLastByte) {
    SensorFrameParser parser;
    const auto found = wire_of(joined({{0x55, 0x12, 0xA1}, kRequest})).read(parser);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found.front().frame, kRequest);
    EXPECT_EQ(found.front().bytes_read, 7U);
}

Bytes any_fragments() {
    const Bytes value = encoded(SensorCommand::value, 3, {0x04, 0x82, 0x79, 0xFF});
    const auto fragments = *rc::gen::container<std::vector<Bytes>>(rc::gen::element(
        kRequest, kReply, kProbe, value, kServo, Bytes{0x12, 0xA1}, Bytes{0x08, 0xA1},
        Bytes{0x20, 0x40}, Bytes{0x06}, Bytes{0x04}, Bytes{0x20}, Bytes{0x55}, Bytes{0xA1}));
    Bytes all;
    for (const Bytes& fragment : fragments) {
        all.insert(all.end(), fragment.begin(), fragment.end());
    }
    return all;
}

RC_GTEST_PROP(SensorFrameParser, FindsARequestInAnyFragmentsWithItsLastByteOrNotAtAll, ()) {
    const Bytes bytes = any_fragments();
    SensorFrameParser parser;
    for (const auto& found : wire_of(bytes).read(parser)) {
        const bool request = found.frame.size() == kSensorRequestBytes;
        RC_ASSERT(!request || found.first_byte + kSensorRequestBytes == found.bytes_read);
    }
}

TEST(SensorFrameParser, AValueThatLooksLikeARequestIsNone) {
    const Bytes reply = encoded(SensorCommand::value, 3, {0x04, 0x82, 0x79, 0xFF});
    EXPECT_EQ(wire_of(reply).frames(), std::vector<Bytes>{reply});
}

TEST(SensorFrameParser, ADamagedValueThatLooksLikeARequestIsNone) {
    Bytes reply = encoded(SensorCommand::value, 3, {0x04, 0x82, 0x79, 0xFF});
    reply.back() ^= 0x01U;
    EXPECT_EQ(wire_of(reply).frames(), std::vector<Bytes>{});
}

// After 12 A2, which would begin a longer value.
TEST(SensorFrameParser, WhatLooksLikeARequestAtTheEndOfADamagedValueIsNone) {
    EXPECT_TRUE(wire_of(joined({{0x08, 0xA1, 0x12, 0xA2}, kRequest})).frames().empty());
}

TEST(SensorFrameParser, AFrameThatDoesNotGoOnIsGivenUp) {
    Wire wire = wire_of({0x06, 0xA1, 0x00});
    wire.pause(kLongestSensorPause);
    wire.add(kRequest);
    SensorFrameParser parser;
    const auto found = wire.read(parser);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found.front().frame, kRequest);
    EXPECT_EQ(parser.rejected()[2].name, "unfinished");
    EXPECT_EQ(parser.rejected()[2].count, 1U);
    EXPECT_EQ(parser.skipped_bytes(), 3U);
}

TEST(SensorFrameParser, AFrameGoesOnAfterTheLongestPause) {
    Wire wire = wire_of({0x06, 0xA1, 0x00});
    wire.pause(kLongestSensorPause - kByteTime);
    wire.add({0x00, 0x58, 0xFF});
    EXPECT_EQ(wire.frames(), std::vector<Bytes>{kReply});
}

TEST(SensorFrameParser, ADamagedByteCostsItsFrameAlone) {
    SensorFrameParser parser;
    const Bytes half{0x04, 0xA1};
    std::span<const std::uint8_t> bytes(half);
    EXPECT_FALSE(parser.next(bytes, Instant{}));
    parser.damaged_byte(Instant{});
    const Bytes rest = joined({{0xFF}, kReply});
    bytes = rest;
    const auto frame = parser.next(bytes, Instant{});
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->data_size, 2);
    EXPECT_EQ(frame->first_byte, 4U);
    EXPECT_EQ(parser.rejected()[1].name, "damaged");
    EXPECT_EQ(parser.rejected()[1].count, 1U);
    EXPECT_EQ(parser.skipped_bytes(), 4U);
}

TEST(SensorFrameParser, AWrongChecksumIsCounted) {
    SensorFrameParser parser;
    EXPECT_TRUE(wire_of({0x04, 0xA1, 0x5B, 0xFF}).read(parser).empty());
    EXPECT_EQ(parser.rejected()[0].name, "checksum");
    EXPECT_EQ(parser.rejected()[0].count, 1U);
}

TEST(SensorFrameParser, AnUnknownCommandIsCounted) {
    SensorFrameParser parser;
    EXPECT_TRUE(wire_of({0x04, 0xB1, 0x4A, 0xFF}).read(parser).empty());
    EXPECT_EQ(parser.rejected()[3].name, "unknown command");
    EXPECT_EQ(parser.rejected()[3].count, 1U);
}

// Address 0 is the receiver's own voltage, which is never requested on the wire.
TEST(SensorFrameParser, AddressZeroIsRefused) {
    EXPECT_TRUE(wire_of({0x04, 0x80, 0x7B, 0xFF}).frames().empty());
}

TEST(SensorFrameParser, AServoFrameOnTheSameWirePassesAsAWhole) {
    SensorFrameParser parser;
    const auto found = wire_of(joined({kServo, kRequest})).read(parser);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found.front().frame, kRequest);
    EXPECT_EQ(parser.servo_frames(), 1U);
    EXPECT_EQ(parser.skipped_bytes(), 0U);
}

TEST(SensorFrameParser, WhatLooksLikeARequestInAServoFrameIsNone) {
    std::vector<std::uint16_t> slots(14, 1500);
    slots[4] = 0xA104;
    slots[5] = 0xFF5A;
    SensorFrameParser parser;
    EXPECT_TRUE(wire_of(joined({{0x55}, servo_frame(slots)})).read(parser).empty());
    EXPECT_EQ(parser.servo_frames(), 1U);
}

std::vector<std::uint16_t> any_slots() {
    return *rc::gen::container<std::vector<std::uint16_t>>(14, rc::gen::arbitrary<std::uint16_t>());
}

RC_GTEST_PROP(SensorFrameParser, NothingIsFoundInServoFramesWithAFlippedByte, ()) {
    std::vector<std::uint16_t> slots = any_slots();
    slots[3] = *rc::gen::element<std::uint16_t>(0xA104, slots[3]);
    slots[4] = *rc::gen::element<std::uint16_t>(0xFF5A, slots[4]);
    Wire wire = wire_of(servo_frame(slots));
    wire.flip(*rc::gen::inRange<std::size_t>(2, 32), *rc::gen::inRange<std::uint8_t>(1, 255));
    RC_ASSERT(wire.frames().empty());
}

RC_GTEST_PROP(SensorFrameParser, NothingIsFoundInServoFramesOfAnyChannels, ()) {
    const auto slots = any_slots();
    Wire wire = wire_of(*rc::gen::element(Bytes{}, Bytes{0x55}, kReply));
    const std::size_t before = wire.frames().size();
    wire.add(servo_frame(slots));
    RC_ASSERT(wire.frames().size() == before);
}

// Values of 0xB00 and more are left out: they could be the power-up frame, which nobody answers.
RC_GTEST_PROP(SensorFrameParser, NoRequestIsFoundInServoFramesThatLostAByte, ()) {
    const auto slots = *rc::gen::container<std::vector<std::uint16_t>>(
        14, rc::gen::map(rc::gen::element(0x104, 0x481, 0x4A1, 0x5FF, 0xA04, 0x491, 0x47A, 0xAFF),
                         [](int slot) { return static_cast<std::uint16_t>(slot); }));
    Wire wire = wire_of(servo_frame(slots));
    wire.lose(*rc::gen::inRange<std::size_t>(0, 32));
    wire.pause(800us);
    wire.add(kRequest);
    SensorFrameParser parser;
    std::size_t requests = 0;
    for (const auto& found : wire.read(parser)) {
        requests += found.frame.size() == kSensorRequestBytes ? 1U : 0U;
    }
    RC_ASSERT(requests == 1U);
}

TEST(SensorFrameParser, FindsTheSameHoweverTheBytesAreCutIntoReads) {
    const Bytes bytes = joined({{0x12, 0xA1}, kRequest, kServo, kReply, {0x04}, kProbe, kReply});
    SensorFrameParser single;
    const auto expected = wire_of(bytes).read(single);
    for (std::size_t cut = 0; cut <= bytes.size(); ++cut) {
        SensorFrameParser parser;
        std::size_t count = 0;
        for (auto part : {std::span(bytes).first(cut), std::span(bytes).subspan(cut)}) {
            while (parser.next(part, Instant{})) {
                ++count;
            }
        }
        EXPECT_EQ(count, expected.size()) << cut;
        EXPECT_EQ(parser.skipped_bytes(), single.skipped_bytes()) << cut;
    }
}

}  // namespace
}  // namespace tribus::ibus_sensor_test
