#include "transports/links/can/can_socket.h"

#include <linux/can.h>
#include <linux/if.h>
#include <linux/rtnetlink.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <iterator>
#include <string>
#include <string_view>
#include <utility>

#include <gtest/gtest.h>

#include "transports/links/can/interface_change.h"

/// A socket of an interface whose name goes to another one, that goes down or away. The loopback
/// interface of a network of the test's own stands for it: no CAN is needed for that.
namespace tribus::test::can_socket_test {
namespace {

using namespace std::chrono_literals;

class SocketOfName : public ::testing::Test {
  protected:
    static CanInterface interface_with(std::uint32_t index, const std::string& name) {
        CanInterface interface;
        interface.name = name;
        interface.kind = "vcan";
        interface.index = index;
        interface.up = true;
        interface.lower_up = true;
        interface.running = true;
        return interface;
    }
    /// The kernel tells of a change of an interface.
    void tell(std::uint32_t index, std::string_view name, std::uint16_t type = RTM_NEWLINK) const {
        struct {
            nlmsghdr head{};
            ifinfomsg link{};
            rtattr attribute{};
            std::array<char, IFNAMSIZ> name{};
        } message;
        message.head.nlmsg_len = sizeof message;
        message.head.nlmsg_type = type;
        message.link.ifi_index = static_cast<int>(index);
        message.link.ifi_flags = IFF_UP | IFF_RUNNING;
        message.attribute.rta_type = IFLA_IFNAME;
        message.attribute.rta_len = sizeof message.attribute + IFNAMSIZ;
        name.copy(message.name.data(), IFNAMSIZ - 1);
        ASSERT_EQ(::send(teller_.get(), &message, sizeof message, 0), sizeof message);
    }
    void put_on_the_bus() const {
        can_frame frame{};
        frame.len = 8;
        ASSERT_EQ(::send(bus_.get(), &frame, sizeof frame, 0), sizeof frame);
    }
    static void pair(UniqueFd& here, UniqueFd& there) {
        std::array<int, 2> ends{};
        ASSERT_EQ(::socketpair(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK, 0, ends.data()), 0);
        here = UniqueFd(ends[0]);
        there = UniqueFd(ends[1]);
    }
    CanSocket socket_on(UniqueFd changes, const std::string& name = "lo") {
        UniqueFd wire;
        pair(wire, bus_);
        return {std::move(wire), std::move(changes), interface_with(kIndex, name)};
    }
    CanSocket socket_of(const std::string& name) {
        UniqueFd changes;
        pair(changes, teller_);
        return socket_on(std::move(changes), name);
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
    CanSocket socket = socket_of("can0");
    tell(kIndex, "can0");
    EXPECT_EQ(read(socket), ReadStatus::nothing);
    EXPECT_EQ(write(socket), WriteStatus::written);
}

/// An ioctl with the name of an interface that is not there may run modprobe.
TEST_F(SocketOfName, AsksTheKernelForNoInterfaceByItsName) {
    CanSocket socket = socket_of("not-there");
    EXPECT_EQ(write(socket), WriteStatus::written);
    tell(kIndex, "not-there");
    EXPECT_EQ(read(socket), ReadStatus::nothing);
    EXPECT_EQ(write(socket, kNow + 1ms), WriteStatus::written);
}

TEST_F(SocketOfName, IsLostAsSoonAsTheNameIsThatOfAnotherInterface) {
    CanSocket socket = socket_of("can0");
    EXPECT_EQ(read(socket), ReadStatus::nothing) << "nothing has happened";
    tell(kIndex, "can1");
    EXPECT_EQ(read(socket), ReadStatus::lost);
    EXPECT_EQ(write(socket), WriteStatus::lost);
}

TEST_F(SocketOfName, IsLostAsSoonAsItsInterfaceIsGone) {
    CanSocket socket = socket_of("can0");
    tell(kIndex, "can0", RTM_DELLINK);
    EXPECT_EQ(read(socket), ReadStatus::lost);
    EXPECT_EQ(write(socket), WriteStatus::lost);
}

TEST_F(SocketOfName, MindsNoChangeOfAnotherInterface) {
    CanSocket socket = socket_of("can0");
    tell(kIndex + 1, "can1");
    tell(kIndex + 1, "can1", RTM_DELLINK);
    EXPECT_EQ(read(socket), ReadStatus::nothing);
    EXPECT_EQ(write(socket), WriteStatus::written);
}

/// Frames that wait may have come from the other bus.
TEST_F(SocketOfName, ReadsNothingMoreThatWaits) {
    CanSocket socket = socket_of("can0");
    // It is empty at first, so that what comes has an age without the kernel's stamp.
    EXPECT_EQ(read(socket), ReadStatus::nothing);
    put_on_the_bus();
    EXPECT_EQ(read(socket), ReadStatus::received);
    put_on_the_bus();
    tell(kIndex, "can1");
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
        CanSocket socket = socket_on(watch_interfaces());
        const bool first = write(socket) == WriteStatus::written &&
                           write(socket, kNow + 1ms) == WriteStatus::written;
        name.take_away();
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

TEST_F(SocketOfName, IsLostAtAWriteBeforeItWasSeenUp) {
    CanSocket socket = socket_of("can0");
    tell(kIndex, "can1");
    EXPECT_EQ(write(socket), WriteStatus::lost);
}

/// The function runs in a process of its own, with a network of its own where that is permitted.
#define EXPECT_IN_A_NETWORK_OF_ITS_OWN(...)                                             \
    EXPECT_EXIT(std::exit(!NameInANetworkOfItsOwn::enter() || (__VA_ARGS__)() ? 0 : 1), \
                ::testing::ExitedWithCode(0), "")

TEST_F(SocketOfName, FollowsItsInterfaceDownAndUp) {
    EXPECT_IN_A_NETWORK_OF_ITS_OWN([this] {
        NameInANetworkOfItsOwn name;
        name.set_up(true);
        CanSocket socket = socket_on(watch_interfaces());
        name.set_up(false);
        const bool down = write(socket) == WriteStatus::unavailable;
        name.set_up(true);
        const bool up = write(socket, kNow + 30ms) == WriteStatus::written;
        return name.done() && down && up;
    });
}

/// The lost message may have said that another interface has the name now.
TEST_F(SocketOfName, IsLostIfTheKernelHadNoRoomToTellEverything) {
    EXPECT_IN_A_NETWORK_OF_ITS_OWN([this] {
        NameInANetworkOfItsOwn name;
        UniqueFd changes = watch_interfaces();
        constexpr int kLeast = 1;
        ::setsockopt(changes.get(), SOL_SOCKET, SO_RCVBUF, &kLeast, sizeof kLeast);
        CanSocket socket = socket_on(std::move(changes));
        for (int change = 0; change < 20; ++change) {
            name.set_up(change % 2 == 0);
        }
        return name.done() && read(socket) == ReadStatus::lost &&
               write(socket) == WriteStatus::lost;
    });
}

TEST_F(SocketOfName, IsToldOfItsInterfaceAlone) {
    EXPECT_IN_A_NETWORK_OF_ITS_OWN([] {
        NameInANetworkOfItsOwn name;
        const UniqueFd own = watch_interfaces();
        const UniqueFd others = watch_interfaces();
        watch_only(own, kIndex);
        watch_only(others, kIndex + 1);
        name.set_up(true);
        const auto told = [](const UniqueFd& changes) {
            std::array<char, 4096> message{};
            return ::recv(changes.get(), message.data(), message.size(), MSG_DONTWAIT) > 0;
        };
        return name.done() && told(own) && !told(others);
    });
}

}  // namespace
}  // namespace tribus::test::can_socket_test
