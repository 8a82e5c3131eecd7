#include "transports/links/can/can_wire.h"

#include <gtest/gtest.h>
#include <linux/can/error.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

namespace tribus::can_wire_test {
namespace {

using namespace std::chrono_literals;

CanFrame standard_frame() {
    CanFrame frame;
    frame.id = 0x123;
    frame.length = 2;
    frame.data[0] = 0x11;
    frame.data[1] = 0x22;
    return frame;
}

CanFrame fd_frame() {
    CanFrame frame;
    frame.id = 0x1ABCDEF0;
    frame.extended = true;
    frame.fd = true;
    frame.bit_rate_switch = true;
    frame.length = 64;
    for (std::size_t index = 0; index < 64; ++index) {
        frame.data[index] = static_cast<std::uint8_t>(index);
    }
    return frame;
}

/// Returns a frame as the kernel makes it: CAN_ERR_ classes in the id, details from data[1] on.
canfd_frame error_frame(std::uint32_t classes, std::uint8_t controller = 0) {
    canfd_frame wire{};
    wire.can_id = CAN_ERR_FLAG | classes;
    wire.len = CAN_ERR_DLC;
    wire.data[1] = controller;
    return wire;
}

/// The frame in the kernel's form.
canfd_frame wire_of(const CanFrame& frame) {
    canfd_frame wire{};
    to_wire(frame, wire);
    return wire;
}

TEST(CanWireTest, AClassicFrameTakes16BytesAndItsIdHasNoFlag) {
    canfd_frame wire{};
    EXPECT_EQ(to_wire(standard_frame(), wire), 16U);
    EXPECT_EQ(wire.can_id, 0x123U);
    EXPECT_EQ(wire.len, 2);
    EXPECT_EQ(wire.data[1], 0x22);
}

TEST(CanWireTest, WhatAClassicFrameDoesNotSayIsZero) {
    canfd_frame wire;
    std::memset(&wire, 0xAA, sizeof wire);
    CanFrame frame;
    frame.id = 0x124;
    frame.length = 1;
    frame.data[0] = 0x11;
    to_wire(frame, wire);
    const std::array<std::uint8_t, 16> expected{0x24, 0x01, 0, 0, 1, 0, 0, 0, 0x11};
    EXPECT_EQ(std::memcmp(&wire, expected.data(), CAN_MTU), 0);
}

TEST(CanWireTest, AnExtendedFdFrameTakes72BytesWithItsFlags) {
    canfd_frame wire{};
    EXPECT_EQ(to_wire(fd_frame(), wire), 72U);
    EXPECT_EQ(wire.can_id, 0x9ABCDEF0U);
    EXPECT_EQ(wire.len, 64);
    EXPECT_EQ(wire.flags, CANFD_BRS);
}

TEST(CanWireTest, NothingOfTheFrameBeforeRemains) {
    canfd_frame wire = wire_of(fd_frame());
    to_wire(standard_frame(), wire);
    const canfd_frame fresh = wire_of(standard_frame());
    EXPECT_EQ(std::memcmp(&wire, &fresh, CAN_MTU), 0);
}

TEST(CanWireTest, FramesComeBackAsTheyWent) {
    CanFrame remote;
    remote.id = 0x7FF;
    remote.remote = true;
    remote.length = 4;
    CanFrame error_passive_sender = fd_frame();
    error_passive_sender.error_state_indicator = true;
    CanFrame slow_sender = error_passive_sender;
    slow_sender.bit_rate_switch = false;
    CanFrame plain_fd = fd_frame();
    plain_fd.bit_rate_switch = false;
    CanFrame extended_remote = remote;
    extended_remote.id = 0x1FFFFFFF;
    extended_remote.extended = true;
    for (const CanFrame& frame : {standard_frame(), fd_frame(), remote, error_passive_sender,
                                  slow_sender, plain_fd, extended_remote}) {
        canfd_frame wire{};
        const std::size_t size = to_wire(frame, wire);
        EXPECT_EQ(from_wire(wire, size), frame) << std::hex << frame.id;
    }
}

/// They may be what an earlier frame left in memory.
TEST(CanWireTest, BytesBeyondTheLengthPassInNoDirectionAndDoNotCount) {
    CanFrame full = standard_frame();
    full.data.fill(0xAA);
    for (std::uint8_t length = 0; length <= kMostClassicBytes; ++length) {
        full.length = length;
        CanFrame clean = full;
        std::fill(clean.data.begin() + length, clean.data.end(), std::uint8_t{0});
        EXPECT_EQ(from_wire(wire_of(full), CAN_MTU), clean) << int{length};
        canfd_frame wire = wire_of(clean);
        std::fill(wire.data + length, std::end(wire.data), std::uint8_t{0xBB});
        EXPECT_EQ(from_wire(wire, CAN_MTU), clean) << int{length};
        EXPECT_TRUE(same_message(full, clean)) << int{length};
        if (length > 0) {
            clean.data[length - 1] ^= 1U;
            EXPECT_FALSE(same_message(full, clean)) << int{length};
        }
    }
}

TEST(CanWireTest, FlagsOfAClassicFrameMeanNothing) {
    canfd_frame wire = wire_of(standard_frame());
    wire.flags = 0xFF;
    EXPECT_EQ(from_wire(wire, CAN_MTU), standard_frame());
}

TEST(CanWireTest, LengthsBeyondTheFrameAreCutBothWays) {
    CanFrame frame = standard_frame();
    frame.length = 200;
    EXPECT_EQ(wire_of(frame).len, 8);
    frame.fd = true;
    EXPECT_EQ(wire_of(frame).len, 64);
    canfd_frame wire{};
    wire.len = 255;
    EXPECT_EQ(from_wire(wire, CAN_MTU)->length, 8);
    EXPECT_EQ(from_wire(wire, CANFD_MTU)->length, 64);
}

TEST(CanWireTest, ErrorFramesAndOtherSizesAreNoFrames) {
    EXPECT_EQ(from_wire(error_frame(CAN_ERR_BUSOFF), CAN_MTU), std::nullopt);
    EXPECT_EQ(from_wire(canfd_frame{}, 0), std::nullopt);
    EXPECT_EQ(from_wire(canfd_frame{}, 15), std::nullopt);
}

TEST(CanWireTest, AMessageIsTheSameWhateverFlagsADriverGivesItBackWith) {
    CanFrame returned = fd_frame();
    returned.bit_rate_switch = false;
    returned.error_state_indicator = true;
    EXPECT_TRUE(same_message(fd_frame(), returned));
    returned.data[63] ^= 1;
    EXPECT_FALSE(same_message(fd_frame(), returned));
    CanFrame other_world = standard_frame();
    other_world.extended = true;
    EXPECT_FALSE(same_message(standard_frame(), other_world));
}

class DifferentMessage : public ::testing::TestWithParam<CanFrame> {};

TEST_P(DifferentMessage, IsNotTheSame) {
    EXPECT_FALSE(same_message(CanFrame{.id = 0x123}, GetParam()));
    EXPECT_FALSE(same_message(GetParam(), CanFrame{.id = 0x123}));
}

/// Each differs in one thing. Bytes of a shorter message are 0 in the longer one.
INSTANTIATE_TEST_SUITE_P(
    Each, DifferentMessage,
    testing::Values(CanFrame{.id = 0x124}, CanFrame{.id = 0x123, .extended = true},
                    CanFrame{.id = 0x123, .remote = true}, CanFrame{.id = 0x123, .fd = true},
                    CanFrame{.id = 0x123, .length = 1}, CanFrame{.id = 0x123, .length = 12}));

TEST(CanWireTest, LongMessagesAreTheSameUpToTheirLength) {
    CanFrame longer = fd_frame();
    longer.length = 12;
    CanFrame other = longer;
    other.data[12] ^= 1U;
    EXPECT_TRUE(same_message(longer, other));
    other.data[11] ^= 1U;
    EXPECT_FALSE(same_message(longer, other));
}

/// There are no remote frames of this kind.
TEST(CanWireTest, NoFdFrameIsRemoteInEitherDirection) {
    CanFrame frame = fd_frame();
    frame.remote = true;
    EXPECT_EQ(wire_of(frame).can_id, 0x9ABCDEF0U);
    canfd_frame wire = wire_of(fd_frame());
    wire.can_id |= CAN_RTR_FLAG;
    EXPECT_EQ(from_wire(wire, CANFD_MTU), fd_frame());
}

TEST(CanWireTest, ErrorFramesSayWhatHappened) {
    const auto report = [](std::uint32_t classes, std::uint8_t controller = 0) {
        return error_report(error_frame(classes, controller)).value_or(CanErrorReport{});
    };
    EXPECT_EQ(report(CAN_ERR_TX_TIMEOUT), CanErrorReport{.transmit_timeout = true});
    EXPECT_EQ(report(CAN_ERR_ACK), CanErrorReport{.no_acknowledge = true});
    EXPECT_EQ(report(CAN_ERR_BUSOFF), CanErrorReport{.bus_off = true});
    EXPECT_EQ(report(CAN_ERR_RESTARTED), CanErrorReport{.restarted = true});
    EXPECT_EQ(report(CAN_ERR_CRTL, CAN_ERR_CRTL_ACTIVE), CanErrorReport{.active = true});
    EXPECT_EQ(report(CAN_ERR_CRTL, CAN_ERR_CRTL_RX_WARNING), CanErrorReport{.warning = true});
    EXPECT_EQ(report(CAN_ERR_CRTL, CAN_ERR_CRTL_TX_WARNING), CanErrorReport{.warning = true});
    EXPECT_EQ(report(CAN_ERR_CRTL, CAN_ERR_CRTL_RX_PASSIVE), CanErrorReport{.passive = true});
    EXPECT_EQ(report(CAN_ERR_CRTL, CAN_ERR_CRTL_TX_PASSIVE), CanErrorReport{.passive = true});
    EXPECT_EQ(report(CAN_ERR_CRTL, CAN_ERR_CRTL_RX_OVERFLOW),
              CanErrorReport{.receive_overflow = true});
    EXPECT_EQ(report(CAN_ERR_CRTL, CAN_ERR_CRTL_TX_OVERFLOW),
              CanErrorReport{.transmit_overflow = true});
}

TEST(CanWireTest, ControllerDetailsCountOnlyInTheirClass) {
    EXPECT_EQ(error_report(error_frame(CAN_ERR_ACK, CAN_ERR_CRTL_TX_PASSIVE)),
              CanErrorReport{.no_acknowledge = true});
}

TEST(CanWireTest, DataFramesAreNoErrorReports) {
    EXPECT_EQ(error_report(wire_of(standard_frame())), std::nullopt);
}

TEST(CanWireTest, SingleBusErrorsAreNotAskedForBecauseTheyCanFlood) {
    EXPECT_EQ(kWantedErrors & (CAN_ERR_BUSERROR | CAN_ERR_PROT | CAN_ERR_LOSTARB), 0U);
    EXPECT_EQ(kWantedErrors, 0x165U);
}

TEST(CanWireTest, FiltersTellStandardFromExtendedAndDataFromRemoteFrames) {
    const std::vector<CanIdMatch> wanted{{.id = 0x123, .mask = kMostStandardId, .extended = false},
                                         {.id = 0x123, .mask = kMostExtendedId, .extended = true}};
    const auto filters = kernel_filters(wanted);
    ASSERT_EQ(filters.size(), 2U);
    EXPECT_EQ(filters[0].can_id, 0x123U);
    EXPECT_EQ(filters[0].can_mask, CAN_EFF_FLAG | CAN_RTR_FLAG | 0x7FFU);
    EXPECT_EQ(filters[1].can_id, CAN_EFF_FLAG | 0x123U);
    EXPECT_EQ(filters[1].can_mask, CAN_EFF_FLAG | CAN_RTR_FLAG | 0x1FFFFFFFU);
}

TEST(CanWireTest, WhoWantsAllIdsGetsRemoteFramesToo) {
    const std::vector<CanIdMatch> wanted{{.id = 0, .mask = 0, .extended = false}};
    const auto filters = kernel_filters(wanted);
    ASSERT_EQ(filters.size(), 1U);
    EXPECT_EQ(filters[0].can_mask, CAN_EFF_FLAG);
}

TEST(CanWireTest, FilterMasksKeepToTheIdsBits) {
    const std::vector<CanIdMatch> wanted{{.id = 0x12345300, .mask = 0xFFFFFF00, .extended = false}};
    const auto filters = kernel_filters(wanted);
    ASSERT_EQ(filters.size(), 1U);
    EXPECT_EQ(filters[0].can_id, 0x300U);
    EXPECT_EQ(filters[0].can_mask, CAN_EFF_FLAG | CAN_RTR_FLAG | 0x700U);
}

TEST(CanWireTest, EachFilterIsThereOnce) {
    const std::vector<CanIdMatch> wanted{
        {.id = 0x300, .mask = 0x7FF}, {.id = 0x300, .mask = 0x7FF}, {.id = 0x301, .mask = 0x7FF}};
    const auto filters = kernel_filters(wanted);
    ASSERT_EQ(filters.size(), 2U);
    EXPECT_EQ(filters[0].can_id, 0x300U);
    EXPECT_EQ(filters[1].can_id, 0x301U);
}

// The system clock is at 1,000,000 s, the steady clock at 1 h.
constexpr Duration kWall = std::chrono::seconds(1'000'000);
constexpr Instant kNow = Instant(std::chrono::hours(1));

// 5 ms earlier everything had been read.
constexpr Instant kRead = kNow - 5ms;

TEST(PlausibleArrivalTest, AFrameIsAsOldAsItsStampSays) {
    EXPECT_EQ(plausible_arrival(kWall - 3ms, kWall, kNow, kRead), (Arrival{kNow - 3ms, true}));
    EXPECT_EQ(plausible_arrival(kWall - 100ms, kWall, kNow, kRead), (Arrival{kNow - 100ms, true}));
}

TEST(PlausibleArrivalTest, WithAnOlderStampItIsAsOldAsItCanBe) {
    EXPECT_EQ(plausible_arrival(kWall - 101ms, kWall, kNow, kRead), (Arrival{kRead, false}));
    EXPECT_EQ(plausible_arrival(kWall - 6s, kWall, kNow, kRead), (Arrival{kRead, false}));
}

TEST(PlausibleArrivalTest, OlderStampsAreBelievedWhereReadingWasHeldUp) {
    EXPECT_EQ(plausible_arrival(kWall - 6s, kWall, kNow, kNow - 7s), (Arrival{kNow - 6s, true}));
}

TEST(PlausibleArrivalTest, AStampFromWhenReadingWasHeldUpCountsBackToThatInstant) {
    EXPECT_EQ(plausible_arrival(kWall - 7s, kWall, kNow, kNow - 7s), (Arrival{kNow - 7s, true}));
    EXPECT_EQ(plausible_arrival(kWall - 7s - 1ns, kWall, kNow, kNow - 7s),
              (Arrival{kNow - 7s, false}));
}

TEST(PlausibleArrivalTest, AStampIsBelievedUpToATenthOfASecondInTheFuture) {
    EXPECT_EQ(plausible_arrival(kWall + 100ms, kWall, kNow, kRead), (Arrival{kNow, true}));
    EXPECT_EQ(plausible_arrival(kWall + 101ms, kWall, kNow, kRead), (Arrival{kRead, false}));
}

TEST(PlausibleArrivalTest, AFrameThatCameAfterTheClockWasReadArrivesNow) {
    EXPECT_EQ(plausible_arrival(kWall + 200us, kWall, kNow, kRead), (Arrival{kNow, true}));
}

TEST(PlausibleArrivalTest, WithAStampFarInTheFutureItIsAsOldAsItCanBe) {
    EXPECT_EQ(plausible_arrival(kWall + 1s, kWall, kNow, kNow - 17s), (Arrival{kNow - 17s, false}));
}

TEST(PlausibleArrivalTest, WithoutAStampItIsAsOldAsItCanBe) {
    EXPECT_EQ(plausible_arrival(std::nullopt, kWall, kNow, kRead), (Arrival{kRead, true}));
}

}  // namespace
}  // namespace tribus::can_wire_test
