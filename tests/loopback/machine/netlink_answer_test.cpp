#include <fcntl.h>
#include <linux/if_arp.h>
#include <linux/if_link.h>
#include <linux/rtnetlink.h>
#include <sys/socket.h>
#include <sys/time.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstddef>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/netlink_messages.h"
#include "transports/links/can/can_netlink.h"
#include "transports/links/unique_fd.h"

/// A socket that a test answers instead of the kernel.
namespace tribus::test::netlink_answer_test {
namespace {

using namespace netlink;
using netlink::Bytes;

Bytes interface_message(const char* name, std::uint16_t flags = 0) {
    ifinfomsg link{};
    link.ifi_type = ARPHRD_CAN;
    return message(RTM_NEWLINK, joined({bytes_of(link), attribute(IFLA_IFNAME, bytes_of(name))}),
                   flags);
}

/// Answers at the second alarm. Only what a handler of signals may use.
struct Answerer {
    int socket = -1;
    const Bytes* answer = nullptr;
    volatile std::sig_atomic_t alarms = 0;
} answerer;

void answer_at_the_second_alarm(int /*signal*/) {
    answerer.alarms = answerer.alarms + 1;
    if (answerer.alarms == 2) {
        ::send(answerer.socket, answerer.answer->data(), answerer.answer->size(), MSG_DONTWAIT);
    }
}

/// An alarm each 2 ms, which interrupts calls.
class Alarms {
  public:
    Alarms() {
        struct sigaction action {};
        action.sa_handler = answer_at_the_second_alarm;
        ::sigaction(SIGALRM, &action, &before_);
        set(2000);
    }
    Alarms(const Alarms&) = delete;
    Alarms& operator=(const Alarms&) = delete;
    ~Alarms() {
        set(0);
        ::sigaction(SIGALRM, &before_, nullptr);
    }

  private:
    static void set(long microseconds) {
        const itimerval each{.it_interval = {.tv_sec = 0, .tv_usec = microseconds},
                             .it_value = {.tv_sec = 0, .tv_usec = microseconds}};
        ::setitimer(ITIMER_REAL, &each, nullptr);
    }

    struct sigaction before_ {};
};

class NetlinkSocket : public testing::Test {
  protected:
    explicit NetlinkSocket(int flags = SOCK_NONBLOCK) {
        std::array<int, 2> ends{};
        EXPECT_EQ(::socketpair(AF_UNIX, SOCK_DGRAM | flags, 0, ends.data()), 0);
        socket_ = UniqueFd(ends[0]);
        kernel_ = UniqueFd(ends[1]);
    }
    void answer(const Bytes& datagram) const {
        ASSERT_EQ(::send(kernel_.get(), datagram.data(), datagram.size(), 0),
                  static_cast<ssize_t>(datagram.size()));
    }
    tl::expected<std::vector<std::string>, int> ask() const {
        const auto found = ask_by(socket_.get(), kRequest);
        if (!found) {
            return tl::unexpected(found.error());
        }
        std::vector<std::string> names;
        for (const CanInterface& interface : *found) {
            names.push_back(interface.name);
        }
        return names;
    }

    const NetlinkRequest kRequest = request_of_interface("can0");
    UniqueFd socket_;
    UniqueFd kernel_;
};

using Names = std::vector<std::string>;

TEST_F(NetlinkSocket, SendsTheRequestOnce) {
    answer(interface_message("can0"));
    EXPECT_EQ(ask(), Names{"can0"});
    Bytes sent(200);
    const ssize_t size = ::recv(kernel_.get(), sent.data(), sent.size(), 0);
    ASSERT_GT(size, 0);
    sent.resize(static_cast<std::size_t>(size));
    EXPECT_EQ(sent, kRequest);
    EXPECT_EQ(::recv(kernel_.get(), sent.data(), sent.size(), 0), -1);
}

TEST_F(NetlinkSocket, ReadsAnAnswerInManyParts) {
    answer(interface_message("lo", NLM_F_MULTI));
    answer(
        joined({interface_message("can0", NLM_F_MULTI), interface_message("can1", NLM_F_MULTI)}));
    answer(message(NLMSG_DONE, Bytes(4), NLM_F_MULTI));
    EXPECT_EQ(ask(), (Names{"lo", "can0", "can1"}));
}

TEST_F(NetlinkSocket, GivesTheErrorOfTheKernel) {
    answer(message(NLMSG_ERROR, bytes_of(-ENODEV)));
    EXPECT_EQ(ask(), tl::unexpected(ENODEV));
}

TEST(OpenedNetlink, WaitsFiveSecondsAtMost) {
    const UniqueFd socket = open_netlink();
    timeval limit{};
    socklen_t size = sizeof limit;
    ASSERT_EQ(::getsockopt(socket.get(), SOL_SOCKET, SO_RCVTIMEO, &limit, &size), 0);
    EXPECT_EQ(limit.tv_sec, 5);
    EXPECT_EQ(limit.tv_usec, 0);
    EXPECT_EQ(::fcntl(socket.get(), F_GETFD), FD_CLOEXEC);
}

TEST_F(NetlinkSocket, SaysThatAnAnswerIsDamaged) {
    answer(interface_message("can0", NLM_F_MULTI));
    answer(Bytes(16));
    EXPECT_EQ(ask(), tl::unexpected(EPROTO));
}

TEST_F(NetlinkSocket, SaysThatNoAnswerCame) {
    EXPECT_EQ(ask(), tl::unexpected(EAGAIN));
}

TEST_F(NetlinkSocket, SaysThatTheRequestCouldNotBeSent) {
    kernel_ = UniqueFd();
    EXPECT_EQ(ask(), tl::unexpected(ECONNREFUSED));
}

class NetlinkSocketThatBlocks : public NetlinkSocket {
  protected:
    NetlinkSocketThatBlocks() : NetlinkSocket(0) {}
};

TEST_F(NetlinkSocketThatBlocks, ReadsAThousandPartsAndNoMore) {
    const auto parts_read = [this](std::size_t parts) {
        std::thread kernel([&] {
            for (std::size_t part = 1; part < parts; ++part) {
                answer(interface_message("can0", NLM_F_MULTI));
            }
            answer(message(NLMSG_DONE, Bytes(4), NLM_F_MULTI));
        });
        const auto names = ask();
        kernel.join();
        return names ? names->size() : 0;
    };
    EXPECT_EQ(parts_read(1000), 999U);
    EXPECT_EQ(parts_read(1001), 0U);
}

TEST_F(NetlinkSocketThatBlocks, GoesOnToWaitAfterASignal) {
    const Bytes can0 = interface_message("can0");
    answerer.socket = kernel_.get();
    answerer.answer = &can0;
    answerer.alarms = 0;
    const Alarms alarms;
    EXPECT_EQ(ask(), Names{"can0"});
}

}  // namespace
}  // namespace tribus::test::netlink_answer_test
