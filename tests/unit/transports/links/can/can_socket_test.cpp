#include "transports/links/can/can_socket.h"

#include <linux/can.h>
#include <linux/if.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <iterator>
#include <string_view>
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
    static WriteStatus write(CanSocket& socket, Instant now = kNow) {
        CanFrame frame;
        frame.length = 8;
        return socket.write(0, {&frame, 1}, now);
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

/// Frames that wait may have come from the other bus.
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

/// The name of the loopback interface in a network of the process's own, where nobody else misses
/// it.
class NameInANetworkOfItsOwn {
  public:
    /// False if this process may not have such a network.
    static bool enter() {
        return ::unshare(CLONE_NEWNET) == 0 || ::unshare(CLONE_NEWUSER | CLONE_NEWNET) == 0;
    }
    void set_up(bool up) {
        line_.ifr_flags = static_cast<short>(up ? IFF_UP : 0);
        done_ = ::ioctl(any_.get(), SIOCSIFFLAGS, &line_) == 0 && done_;
    }
    /// The kernel renames what is down.
    void take_away() {
        set_up(false);
        std::string_view("elsewhere").copy(std::begin(line_.ifr_newname), IFNAMSIZ - 1);
        done_ = ::ioctl(any_.get(), SIOCSIFNAME, &line_) == 0 && done_;
    }
    bool done() const { return done_; }

  private:
    UniqueFd any_{::socket(AF_UNIX, SOCK_DGRAM, 0)};
    ifreq line_{{"lo"}, {}};
    bool done_ = any_.get() >= 0;
};

class FramesBehindAName : public SocketOfName {
  protected:
    /// Lets `send` send while the name is away, after one snapshot left. Returns how many left
    /// after that.
    template <class Send>
    int sent_without_the_name(Send send) {
        NameInANetworkOfItsOwn name;
        name.set_up(true);
        CanSocket socket = socket_of(kIndex);
        const bool first = write(socket) == WriteStatus::written &&
                           write(socket, kNow + 1ms) == WriteStatus::written;
        name.take_away();
        tell_of_a_change();
        const int before = taken();
        send(socket);
        return first && name.done() && before == 1 ? taken() : -1;
    }
    int taken() const {
        std::array<char, 80> frame{};
        int count = 0;
        while (::recv(bus_.get(), frame.data(), frame.size(), MSG_DONTWAIT) > 0) {
            ++count;
        }
        return count;
    }
};

/// `send` runs in a process of its own, which ends with the number of frames that left: 0 too where
/// it may have no network of its own.
#define EXPECT_NONE_SENT(send)                                                                \
    EXPECT_EXIT(std::exit(NameInANetworkOfItsOwn::enter() ? sent_without_the_name(send) : 0), \
                ::testing::ExitedWithCode(0), "")

TEST_F(FramesBehindAName, DoNotLeaveWhereTheyAreWritten) {
    EXPECT_NONE_SENT([](CanSocket& socket) { write(socket, kNow + 2ms); });
}

/// The second snapshot waits until the first one has left the kernel.
TEST_F(FramesBehindAName, DoNotLeaveWhereTheyWaited) {
    EXPECT_NONE_SENT([](CanSocket& socket) { socket.poll(kNow + 2ms); });
}

/// Until an interface was seen to be up, each write looks at it without news from the kernel.
TEST_F(SocketOfName, IsLostAtAWriteBeforeItWasSeenUp) {
    CanSocket socket = socket_of(kIndex + 1);
    EXPECT_EQ(write(socket), WriteStatus::lost);
}

}  // namespace
}  // namespace tribus::test::can_socket_test
