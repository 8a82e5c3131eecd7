#include "transports/links/can/can_socket.h"

#include <linux/can.h>
#include <sys/socket.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <utility>

#include <gtest/gtest.h>

/// A socket of an interface whose name goes to another one. The loopback interface stands for the
/// one that has the name now: no CAN is needed for that.
namespace tribus::test::can_socket_test {
namespace {

using namespace std::chrono_literals;

class SocketOfName : public ::testing::Test {
  protected:
    static CanInterface interface_with(std::uint32_t index) {
        CanInterface interface;
        interface.name = "lo";
        interface.kind = "vcan";
        interface.index = index;
        interface.up = true;
        interface.lower_up = true;
        return interface;
    }
    /// The kernel tells of a change of some network interface.
    void tell_of_a_change() const { ASSERT_EQ(::send(teller_.get(), "x", 1, 0), 1); }
    void put_on_the_bus() const {
        can_frame frame{};
        frame.len = 8;
        ASSERT_EQ(::send(bus_.get(), &frame, sizeof frame, 0), sizeof frame);
    }
    CanSocket socket_of(std::uint32_t index) {
        const auto pair = [](UniqueFd& here, UniqueFd& there) {
            std::array<int, 2> ends{};
            ASSERT_EQ(::socketpair(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK, 0, ends.data()), 0);
            here = UniqueFd(ends[0]);
            there = UniqueFd(ends[1]);
        };
        UniqueFd wire;
        UniqueFd changes;
        pair(wire, bus_);
        pair(changes, teller_);
        return {std::move(wire), std::move(changes), interface_with(index)};
    }
    static constexpr Instant kNow = Instant(1h);
    static ReadStatus read(CanSocket& socket) {
        CanReception reception;
        return socket.read(reception, kNow, 1h);
    }
    static WriteStatus write(CanSocket& socket) {
        CanFrame frame;
        frame.length = 8;
        return socket.write(0, {&frame, 1}, kNow);
    }

    UniqueFd bus_;
    UniqueFd teller_;
    /// That of the loopback interface, in the kernel always.
    static constexpr std::uint32_t kIndex = 1;
};

TEST_F(SocketOfName, StaysWhileTheNameIsThatOfItsInterface) {
    CanSocket socket = socket_of(kIndex);
    tell_of_a_change();
    EXPECT_EQ(read(socket), ReadStatus::nothing);
    EXPECT_EQ(write(socket), WriteStatus::written);
}

TEST_F(SocketOfName, IsLostAsSoonAsTheNameIsThatOfAnotherInterface) {
    CanSocket socket = socket_of(kIndex + 1);
    EXPECT_EQ(read(socket), ReadStatus::nothing) << "nothing has happened";
    tell_of_a_change();
    EXPECT_EQ(read(socket), ReadStatus::lost);
    EXPECT_EQ(write(socket), WriteStatus::lost);
}

/// What waits may have come from the other bus.
TEST_F(SocketOfName, ReadsNothingMoreThatWaits) {
    CanSocket socket = socket_of(kIndex + 1);
    // It is empty at first, so that what comes has an age without the kernel's stamp.
    EXPECT_EQ(read(socket), ReadStatus::nothing);
    put_on_the_bus();
    EXPECT_EQ(read(socket), ReadStatus::received);
    put_on_the_bus();
    tell_of_a_change();
    EXPECT_EQ(read(socket), ReadStatus::lost);
    EXPECT_EQ(socket.status().counts.received, 1U);
}

TEST_F(SocketOfName, SendsNothingMoreToTheOtherBus) {
    CanSocket socket = socket_of(kIndex + 1);
    tell_of_a_change();
    EXPECT_EQ(write(socket), WriteStatus::lost);
    std::array<char, 80> sent{};
    EXPECT_LT(::recv(bus_.get(), sent.data(), sent.size(), MSG_DONTWAIT), 0);
}

/// It is looked at without a telling, too, while it does not send.
TEST_F(SocketOfName, IsLostAtTheNextLookAtALineThatIsDown) {
    CanInterface down = interface_with(kIndex + 1);
    CanSocket socket(UniqueFd(::socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK, 0)),
                     UniqueFd(::socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK, 0)), down);
    EXPECT_EQ(write(socket), WriteStatus::lost);
}

}  // namespace
}  // namespace tribus::test::can_socket_test
