#include <fcntl.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "transports/links/udp/udp_link.h"
#include "transports/links/udp/udp_medium.h"

/// Whom a UDP link hears and answers, and which addresses lead to each other.
namespace tribus::test::udp_peer_test {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// The port of a socket that has one.
std::string port_of(int descriptor) {
    sockaddr_storage address{};
    socklen_t size = sizeof address;
    EXPECT_EQ(::getsockname(descriptor, reinterpret_cast<sockaddr*>(&address), &size), 0);
    return std::to_string(ntohs(reinterpret_cast<const sockaddr_in&>(address).sin_port));
}

/// An input at an address with a free port, which replaces the last characters.
struct Input {
    explicit Input(const std::string& host, const std::string& sender = {}) {
        for (int port = 20000; port < 60000 && !link; port += 7) {
            address = host + ":" + std::to_string(port);
            auto opened = UdpLink::open(address, SettingScope::input, sender);
            link = opened ? std::move(*opened) : nullptr;
        }
        EXPECT_NE(link, nullptr);
    }
    std::string address{};
    std::unique_ptr<UdpLink> link{};
};

std::unique_ptr<UdpLink> output_to(const std::string& address) {
    auto opened = UdpLink::open(address, SettingScope::output);
    EXPECT_TRUE(opened) << opened.error();
    return std::move(*opened);
}

std::string with_port_of(const Input& input, const std::string& host) {
    return host + input.address.substr(input.address.rfind(':'));
}

Bytes read_by(UdpLink& link) {
    Reception reception;
    return link.read(reception) == ReadStatus::received
               ? Bytes(reception.view().begin(), reception.view().end())
               : Bytes{0xEE};
}

constexpr std::uint8_t kNothing = 0xEE;

TEST(UdpPeer, AnEmptyDatagramIsOneToo) {
    const Input input("127.0.0.1");
    const auto output = output_to(input.address);
    errno = EPERM;
    EXPECT_EQ(output->write({}), WriteStatus::written);
    EXPECT_EQ(output->write(Bytes{7}), WriteStatus::written);
    EXPECT_EQ(read_by(*input.link), Bytes{});
    EXPECT_EQ(read_by(*input.link), Bytes{7});
    EXPECT_EQ(read_by(*input.link), Bytes{kNothing});
}

TEST(UdpPeer, AnEmptyDatagramIsDiscardedWithThoseBehindIt) {
    const Input input("127.0.0.1");
    const auto output = output_to(input.address);
    output->write({});
    output->write(Bytes{7});
    input.link->discard_unread();
    EXPECT_EQ(read_by(*input.link), Bytes{kNothing});
}

TEST(UdpPeer, WhoSendsFasterThanADiscardReadsDoesNotHoldIt) {
    const Input input("127.0.0.1");
    constexpr int kRoom = 200'000;
    ASSERT_EQ(::setsockopt(input.link->descriptor(), SOL_SOCKET, SO_RCVBUF, &kRoom, sizeof kRoom),
              0);
    const auto output = output_to(input.address);
    for (int i = 0; i < 260; ++i) {
        ASSERT_EQ(output->write(Bytes{7}), WriteStatus::written);
    }
    input.link->discard_unread();
    int left = 0;
    while (read_by(*input.link) == Bytes{7}) {
        ++left;
    }
    EXPECT_EQ(left, 260 - 256);
}

TEST(UdpPeer, AnOutputSendsToItsAddressWhateverItHears) {
    const Input input("127.0.0.1");
    const auto output = output_to(input.address);
    output->write(Bytes{1});
    const auto stranger = output_to("127.0.0.1:" + port_of(output->descriptor()));
    ASSERT_EQ(stranger->write(Bytes{2}), WriteStatus::written);
    ASSERT_EQ(read_by(*output), Bytes{2});
    EXPECT_EQ(output->write(Bytes{3}), WriteStatus::written);
    EXPECT_EQ(read_by(*input.link), Bytes{1});
    EXPECT_EQ(read_by(*input.link), Bytes{3});
}

TEST(UdpPeer, AStrangerIsNotAnswered) {
    const Input input("127.0.0.1", "127.0.0.2");
    const auto stranger = output_to(input.address);
    ASSERT_EQ(stranger->write(Bytes{1}), WriteStatus::written);
    EXPECT_EQ(read_by(*input.link), Bytes{});
    EXPECT_EQ(input.link->write(Bytes{2}), WriteStatus::unavailable);
}

TEST(UdpPeer, TheKernelIsAskedForNothingWhileNobodyIsKnown) {
    const Input input("127.0.0.1");
    errno = 0;
    EXPECT_EQ(input.link->write(Bytes{2}), WriteStatus::unavailable);
    EXPECT_EQ(errno, 0);
}

TEST(UdpPeer, NothingOfTheReadBeforeIsLeft) {
    const Input input("127.0.0.1");
    Reception reception;
    reception.count = 9;
    reception.full = true;
    reception.goes_on = true;
    reception.damaged.set();
    EXPECT_EQ(input.link->read(reception), ReadStatus::nothing);
    EXPECT_EQ(reception.count, 0U);
    EXPECT_FALSE(reception.full || reception.goes_on || reception.damaged.any());
}

// docs/protocols/network.md: one input has one version.
TEST(UdpPeer, AnInputOfVersion6HearsNothingOfVersion4) {
    const Input input("[::]");
    const auto version_4 = output_to(with_port_of(input, "127.0.0.1"));
    const auto version_6 = output_to(with_port_of(input, "[::1]"));
    version_4->write(Bytes{4});
    version_6->write(Bytes{6});
    EXPECT_EQ(read_by(*input.link), Bytes{6});
    EXPECT_EQ(read_by(*input.link), Bytes{kNothing});
}

TEST(UdpPeer, NoOtherProgramInheritsItsSocket) {
    const Input input("127.0.0.1");
    EXPECT_NE(::fcntl(input.link->descriptor(), F_GETFD) & FD_CLOEXEC, 0);
    EXPECT_NE(::fcntl(input.link->descriptor(), F_GETFL) & O_NONBLOCK, 0);
}

TEST(UdpPeer, SaysWhatIsWrongWithAnAddress) {
    const auto link = UdpLink::open("127.0.0.1", SettingScope::output);
    ASSERT_FALSE(link);
    EXPECT_EQ(link.error(),
              "127.0.0.1: the port is missing; give an address with a port, such as "
              "127.0.0.1:5501");
    const auto deaf = UdpLink::open("127.0.0.1:5501", SettingScope::output, "nobody");
    ASSERT_FALSE(deaf);
    EXPECT_EQ(deaf.error(), "127.0.0.1:5501: \"nobody\" is not an IP address");
}

/// Drops the rights of root during the object's lifetime: they would allow any port.
class WithoutRoot {
  public:
    WithoutRoot() { [[maybe_unused]] const int failed = ::seteuid(65534); }
    WithoutRoot(const WithoutRoot&) = delete;
    WithoutRoot& operator=(const WithoutRoot&) = delete;
    ~WithoutRoot() {
        if (::seteuid(::getuid()) != 0) {
            std::abort();
        }
    }
};

// Ranges for documentation (RFC 5737, RFC 3849).
TEST(UdpPeer, AnAddressIsMissingForAnybodyWhereNoInterfaceHasIt) {
    const WithoutRoot without_root;
    EXPECT_TRUE(UdpLink::is_missing("[2001:db8::7]:5501"));
    EXPECT_TRUE(UdpLink::is_missing("192.0.2.7:5501"));
    errno = EADDRNOTAVAIL;
    EXPECT_FALSE(UdpLink::is_missing("127.0.0.1:5501"));
    EXPECT_FALSE(UdpLink::is_missing("[::1]:5501"));
}

bool same_host(const std::string& one, const std::string& other) {
    return is_same_host(*parse_udp_address(one), *parse_udp_address(other));
}

TEST(UdpHost, IsTheSameWhateverThePort) {
    EXPECT_TRUE(same_host("192.0.2.7:1", "192.0.2.7:2"));
    EXPECT_FALSE(same_host("192.0.2.7:1", "192.0.2.8:1"));
    EXPECT_TRUE(same_host("[2001:db8::7]:1", "[2001:db8::7]:2"));
    EXPECT_FALSE(same_host("[2001:db8::7]:1", "[2001:db8::8]:1"));
    EXPECT_FALSE(same_host("0.0.0.0:1", "[::]:1"));
}

struct Way {
    const char* to;
    const char* at;
    bool arrives;
};

class UdpWay : public ::testing::TestWithParam<Way> {};

TEST_P(UdpWay, ArrivesOrNot) {
    const auto& [to, at, arrives] = GetParam();
    EXPECT_EQ(kUdpMedium.reaches(to, at), arrives) << to << " at " << at;
}

INSTANTIATE_TEST_SUITE_P(
    Addresses, UdpWay,
    ::testing::Values(
        Way{"127.0.0.1:5501", "127.0.0.1:5501", true},
        Way{"127.0.0.1:5501", "127.0.0.1:5502", false},
        Way{"127.0.0.1:5501", "127.0.0.2:5501", false},
        Way{"192.0.2.7:5501", "192.0.2.7:5501", true}, Way{"192.0.2.7:5501", "0.0.0.0:5501", false},
        Way{"192.0.2.7:5501", "127.0.0.1:5501", false}, Way{"127.0.0.1:5501", "0.0.0.0:5501", true},
        Way{"127.0.0.1:5501", "0.0.0.0:5502", false}, Way{"0.0.0.0:5501", "127.0.0.1:5501", true},
        Way{"0.0.0.0:5501", "192.0.2.7:5501", false}, Way{"0.0.0.0:5501", "0.0.0.0:5501", true},
        Way{"[::1]:5501", "[::]:5501", true}, Way{"[::]:5501", "[::1]:5501", true},
        Way{"[::1]:5501", "[::2]:5501", false}, Way{"[2001:db8::7]:5501", "[::]:5501", false},
        Way{"127.0.0.1:5501", "[::]:5501", false}, Way{"127.0.0.1:5501", "[::1]:5501", false},
        Way{"[::1]:5501", "0.0.0.0:5501", false}, Way{"nonsense", "127.0.0.1:5501", false},
        Way{"127.0.0.1:5501", "nonsense", false}));

}  // namespace
}  // namespace tribus::test::udp_peer_test
