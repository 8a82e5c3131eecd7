#include "transports/codecs/dronecan/transfer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <string_view>
#include <vector>

#include "tests/support/streams.h"

namespace tribus::dronecan::transfer_test {
namespace {

using test::Bytes;
using test::from_hex;

constexpr std::uint64_t kRcInputSignature = 0x771555E596AAB4CF;

std::vector<CanFrame> frames_of(const TransferHead& head, std::uint64_t signature,
                                std::span<const std::uint8_t> payload, bool fd = false) {
    std::array<CanFrame, 64> frames;
    const std::size_t count = encode_transfer(head, signature, payload, fd, frames);
    return {frames.begin(), frames.begin() + static_cast<std::ptrdiff_t>(count)};
}

CanFrame frame_of(std::uint32_t id, std::string_view data, bool fd = false) {
    CanFrame frame{.id = id, .extended = true, .fd = fd, .bit_rate_switch = fd};
    const Bytes bytes = from_hex(data);
    frame.length = static_cast<std::uint8_t>(bytes.size());
    std::ranges::copy(bytes, frame.data.begin());
    return frame;
}

Bytes numbered(std::size_t count) {
    Bytes bytes(count);
    std::iota(bytes.begin(), bytes.end(), std::uint8_t{1});
    return bytes;
}

constexpr TransferHead kRcInput{.data_type_id = 1140, .source = 42, .priority = 8};

TransferHead rc_input(std::uint8_t transfer_id) {
    TransferHead head = kRcInput;
    head.transfer_id = transfer_id;
    return head;
}

// Examples of docs/protocols/can.md, "DroneCAN: worked examples", in their order.
TEST(DronecanEncode, RcInputOf16ChannelsTakesFiveFrames) {
    EXPECT_EQ(
        frames_of(rc_input(5), kRcInputSignature,
                  from_hex("0100C80E834C4B04145785DC5406A460876C7D07DC3DC7DB5DD5DE50")),
        (std::vector{frame_of(0x0804742A, "13C30100C80E8385"),
                     frame_of(0x0804742A, "4C4B04145785DC25"),
                     frame_of(0x0804742A, "5406A460876C7D05"),
                     frame_of(0x0804742A, "07DC3DC7DB5DD525"), frame_of(0x0804742A, "DE5045")}));
}

TEST(DronecanEncode, TheLastTransferIdAndToggleShareTheTail) {
    EXPECT_EQ(
        frames_of(rc_input(31), kRcInputSignature,
                  from_hex("0200000DC5DC5843DC5DC5DC5DC5DC5DC5DC5DC5DC5DC5DC5DC5DC50")),
        (std::vector{frame_of(0x0804742A, "1F670200000DC59F"),
                     frame_of(0x0804742A, "DC5843DC5DC5DC3F"),
                     frame_of(0x0804742A, "5DC5DC5DC5DC5D1F"),
                     frame_of(0x0804742A, "C5DC5DC5DC5DC53F"), frame_of(0x0804742A, "DC505F")}));
}

TEST(DronecanEncode, SevenBytesAreOneFrameWithoutCrc) {
    const TransferHead raw_command{
        .data_type_id = 1030, .source = 10, .priority = 8, .transfer_id = 9};
    EXPECT_EQ(frames_of(raw_command, 0x217F5C87D7EC951D, from_hex("0003FDF0080010")),
              std::vector{frame_of(0x0804060A, "0003FDF0080010C9")});
}

TEST(DronecanEncode, AnonymousMessageHasADiscriminatorOfItsPayload) {
    const TransferHead allocation{.data_type_id = 1, .priority = 24};
    EXPECT_EQ(frames_of(allocation, 0x0B2A812620A11D40, from_hex("01001122334455")),
              std::vector{frame_of(0x18D45D00, "01001122334455C0")});
}

TEST(DronecanEncode, EmptyRequestIsATailByte) {
    const TransferHead get_node_info{.kind = TransferKind::request,
                                     .data_type_id = 1,
                                     .source = 127,
                                     .destination = 42,
                                     .priority = 24,
                                     .transfer_id = 3};
    EXPECT_EQ(frames_of(get_node_info, 0xEE468A8121C46A9E, {}),
              std::vector{frame_of(0x1801AAFF, "C3")});
}

TEST(DronecanEncode, FdFrameIsPaddedWithZerosBeforeTheTail) {
    const std::vector<CanFrame> frames =
        frames_of(rc_input(1), kRcInputSignature, numbered(8), true);
    EXPECT_EQ(frames, std::vector{frame_of(0x0804742A, "0102030405060708000000C1", true)});
}

// With the tail byte, one byte too few for an allowed length: pydronecan 1.0.27 sends 63 bytes
// here.
TEST(DronecanEncode, SixtyTwoBytesAreA64ByteFdFrame) {
    const std::vector<CanFrame> frames =
        frames_of(rc_input(1), kRcInputSignature, numbered(62), true);
    ASSERT_EQ(frames.size(), 1);
    EXPECT_EQ(frames[0].length, 64);
    EXPECT_EQ(frames[0].data[61], 62);
    EXPECT_EQ(frames[0].data[62], 0);
    EXPECT_EQ(frames[0].data[63], 0xC1);
}

TEST(DronecanEncode, LastFdFrameOfSeveralIsPaddedTo64BytesToo) {
    for (const std::size_t bytes : {123U, 186U}) {
        const std::vector<CanFrame> frames =
            frames_of(rc_input(0), kRcInputSignature, numbered(bytes), true);
        ASSERT_EQ(frames.size(), frame_count(bytes, true));
        for (const CanFrame& frame : frames) {
            EXPECT_EQ(frame.length, 64) << bytes;
        }
        EXPECT_EQ(frames.back().data[62], 0) << bytes;
    }
}

TEST(DronecanEncode, FdCrcIsOverThePaddingOfTheLastFrameToo) {
    Bytes carried = numbered(70);
    const std::vector<CanFrame> frames = frames_of(rc_input(0), kRcInputSignature, carried, true);
    ASSERT_EQ(frames.size(), 2);
    ASSERT_EQ(frames[1].length, 12);  // 9 bytes, 2 of padding, the tail
    carried.resize(72);
    const std::uint16_t crc = transfer_crc(kRcInputSignature, carried);
    EXPECT_EQ(frames[0].data[0], crc & 0xFF);
    EXPECT_EQ(frames[0].data[1], crc >> 8);
}

TEST(DronecanEncode, CountsFramesOnBothSidesOfEachLimit) {
    struct Row {
        std::size_t bytes;
        bool fd;
        std::size_t frames;
    };
    constexpr Row kRows[] = {{0, false, 1},  {7, false, 1},  {8, false, 2},   {12, false, 2},
                             {13, false, 3}, {0, true, 1},   {63, true, 1},   {64, true, 2},
                             {124, true, 2}, {125, true, 3}, {300, false, 44}};
    for (const Row& row : kRows) {
        EXPECT_EQ(frame_count(row.bytes, row.fd), row.frames) << row.bytes;
        EXPECT_EQ(frames_of(rc_input(0), kRcInputSignature, Bytes(row.bytes), row.fd).size(),
                  row.frames);
    }
}

TEST(DronecanEncode, RefusesWhatHasNoFrames) {
    std::array<CanFrame, 1> frames;
    EXPECT_EQ(encode_transfer(rc_input(0), 0, numbered(8), false, frames), 0);
    const TransferHead anonymous{.data_type_id = 1};
    EXPECT_EQ(frames_of(anonymous, 0, numbered(8)).size(), 0);
    EXPECT_EQ(frames_of({.data_type_id = 4}, 0, numbered(1)).size(), 0);
    EXPECT_EQ(frames_of({.kind = TransferKind::request, .source = 1}, 0, {}).size(), 0);
    EXPECT_EQ(frames_of({.kind = TransferKind::response, .destination = 1}, 0, {}).size(), 0);
}

// docs/protocols/can.md, "DroneCAN: RCInput": the CRC starts with the signature of RCInput.
TEST(DronecanCrc, StartsWithTheSignature) {
    EXPECT_EQ(transfer_crc(kRcInputSignature, {}), 0x235D);
}

TEST(DronecanIds, EveryHeadIsReadBack) {
    for (const TransferKind kind :
         {TransferKind::message, TransferKind::request, TransferKind::response}) {
        const bool message = kind == TransferKind::message;
        for (std::uint32_t type = 0; type <= (message ? 0xFFFFU : 0xFFU); ++type) {
            const TransferHead head{.kind = kind,
                                    .data_type_id = static_cast<std::uint16_t>(type),
                                    .source = static_cast<NodeId>(1 + type % kMostNodeId),
                                    .destination = message ? kNobody : NodeId{99},
                                    .priority = static_cast<std::uint8_t>(type % 32),
                                    .transfer_id = static_cast<std::uint8_t>(type / 7 % 32)};
            const std::vector<CanFrame> frames = frames_of(head, 0, {});
            ASSERT_EQ(head_of(frames.at(0)), head);
            ASSERT_TRUE(ids_of(kind, head.data_type_id).matches(frames[0]));
            ASSERT_FALSE(ids_of(kind, head.data_type_id ^ 1U).matches(frames[0]));
        }
    }
}

TEST(DronecanIds, KindsOfTheSameNumberAreKeptApart) {
    const CanIdMatch request = ids_of(TransferKind::request, 1);
    EXPECT_FALSE(request.overlaps(ids_of(TransferKind::response, 1)));
    EXPECT_FALSE(request.overlaps(ids_of(TransferKind::message, 1)));
}

TEST(DronecanIds, AnonymousMessageIsReadBackWithoutItsDiscriminator) {
    for (std::uint16_t type = 0; type <= 3; ++type) {
        const TransferHead head{.data_type_id = type, .priority = 3, .transfer_id = 7};
        const CanFrame frame = frame_of(can_id_of(head, 0x3FFF), "C7");
        EXPECT_EQ(head_of(frame), head);
        EXPECT_TRUE(anonymous_ids_of(type).matches(frame));
        EXPECT_FALSE(anonymous_ids_of(type ^ 1U).matches(frame));
        EXPECT_FALSE(anonymous_ids_of(type).matches(frame_of(can_id_of(head) | 1U, "C7")));
    }
}

TEST(DronecanIds, WhatCannotBeDronecanHasNoHead) {
    CanFrame standard = frame_of(0x123, "C0");
    standard.extended = false;
    EXPECT_FALSE(head_of(standard));
    CanFrame remote = frame_of(0x0804742A, "C0");
    remote.remote = true;
    EXPECT_FALSE(head_of(remote));
    EXPECT_FALSE(head_of(frame_of(0x0804742A, "")));
    EXPECT_FALSE(head_of(frame_of(0x1801AA80, "C0"))) << "a service from nobody";
    EXPECT_FALSE(head_of(frame_of(0x180180FF, "C0"))) << "a service to nobody";
    EXPECT_FALSE(head_of(frame_of(0x0804742A, "E0"))) << "a start with a toggle";
    EXPECT_FALSE(head_of(frame_of(0x18D45D00, "0000000000000080"))) << "anonymous, not alone";
    EXPECT_FALSE(head_of(frame_of(0x0804742A, "00000000000080"))) << "not the last, not full";
    EXPECT_FALSE(head_of(frame_of(0x0804742A, "0000000000000080", true))) << "not full for FD";
    CanFrame long_classic = frame_of(0x0804742A, "C0");
    long_classic.length = 200;
    EXPECT_FALSE(head_of(long_classic)) << "a length that no frame has";
}

}  // namespace
}  // namespace tribus::dronecan::transfer_test
