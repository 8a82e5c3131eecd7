#include "transports/links/udp/udp_link.h"

#include <netinet/in.h>
#include <sys/socket.h>

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace tribus::udp_link_test {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// An address of this machine at which nobody receives.
std::string free_address(const std::string& host = "127.0.0.1") {
    const auto parsed = parse_udp_address(host + ":1");
    EXPECT_TRUE(parsed) << host;
    auto address = parsed->storage;
    reinterpret_cast<sockaddr_in&>(address).sin_port = 0;
    const UniqueFd fd(::socket(address.ss_family, SOCK_DGRAM | SOCK_CLOEXEC, 0));
    auto* const place = reinterpret_cast<sockaddr*>(&address);
    socklen_t size = parsed->size;
    EXPECT_EQ(::bind(fd.get(), place, size), 0);
    EXPECT_EQ(::getsockname(fd.get(), place, &size), 0);
    return host + ":" + std::to_string(ntohs(reinterpret_cast<sockaddr_in&>(address).sin_port));
}

struct Pair {
    explicit Pair(const std::string& host = "127.0.0.1") : address(free_address(host)) {
        auto input = UdpLink::open(address, SettingScope::input);
        auto output = UdpLink::open(address, SettingScope::output);
        EXPECT_TRUE(input) << input.error();
        EXPECT_TRUE(output) << output.error();
        receiver = std::move(*input);
        sender = std::move(*output);
    }
    Bytes read() {
        Reception reception;
        reception.count = 99;
        reception.damaged.set();
        EXPECT_EQ(receiver->read(reception), ReadStatus::received);
        EXPECT_TRUE(reception.damaged.none());
        EXPECT_TRUE(reception.full) << "another datagram may wait";
        return {reception.view().begin(), reception.view().end()};
    }
    bool is_empty() {
        Reception reception;
        return receiver->read(reception) == ReadStatus::nothing && reception.count == 0;
    }

    std::string address;
    std::unique_ptr<UdpLink> receiver;
    std::unique_ptr<UdpLink> sender;
};

TEST(UdpLink, ReadsOneDatagramAtATime) {
    Pair pair;
    EXPECT_EQ(pair.sender->write(Bytes{1, 2, 3}), WriteStatus::written);
    EXPECT_EQ(pair.sender->write(Bytes{4}), WriteStatus::written);
    EXPECT_EQ(pair.read(), (Bytes{1, 2, 3}));
    EXPECT_EQ(pair.read(), Bytes{4});
    EXPECT_TRUE(pair.is_empty());
}

TEST(UdpLink, RunsOverVersion6Too) {
    Pair pair("[::1]");
    EXPECT_EQ(pair.sender->write(Bytes{5, 6}), WriteStatus::written);
    EXPECT_EQ(pair.read(), (Bytes{5, 6}));
}

Bytes read_by(UdpLink& link) {
    Reception reception;
    return link.read(reception) == ReadStatus::received
               ? Bytes(reception.view().begin(), reception.view().end())
               : Bytes{};
}

TEST(UdpLink, AnInputAnswersTheSenderOfTheDatagramThatItReadLast) {
    for (const std::string host : {"127.0.0.1", "[::1]"}) {
        Pair pair(host);
        const auto other = UdpLink::open(pair.address, SettingScope::output);
        EXPECT_EQ(pair.receiver->write(Bytes{9}), WriteStatus::unavailable) << "nobody is known";
        ASSERT_EQ(pair.sender->write(Bytes{1}), WriteStatus::written);
        ASSERT_EQ((*other)->write(Bytes{2}), WriteStatus::written);
        EXPECT_EQ(pair.read(), Bytes{1});
        EXPECT_EQ(pair.receiver->write(Bytes{3}), WriteStatus::written);
        EXPECT_EQ(pair.read(), Bytes{2});
        EXPECT_EQ(pair.receiver->write(Bytes{4}), WriteStatus::written);
        EXPECT_EQ(read_by(*pair.sender), Bytes{3});
        EXPECT_EQ(read_by(*pair.sender), Bytes{}) << "the other one was answered";
        EXPECT_EQ(read_by(**other), Bytes{4});
    }
}

/// DSCP 46, RFC 3246, in the upper six bits of the byte that once was the type of service.
TEST(UdpLink, MarksDatagramsAsThoseThatMustNotWait) {
    const Pair version_4;
    const Pair version_6("[::1]");
    const auto mark = [](const UdpLink& link, int level, int option) {
        int value = 0;
        socklen_t size = sizeof value;
        EXPECT_EQ(::getsockopt(link.descriptor(), level, option, &value, &size), 0);
        return value;
    };
    for (const UdpLink* link : {version_4.sender.get(), version_4.receiver.get()}) {
        EXPECT_EQ(mark(*link, IPPROTO_IP, IP_TOS), 0xB8);
    }
    for (const UdpLink* link : {version_6.sender.get(), version_6.receiver.get()}) {
        EXPECT_EQ(mark(*link, IPPROTO_IPV6, IPV6_TCLASS), 0xB8);
    }
}

TEST(UdpLink, ReadsALongestDatagramInPartsAndNothingOfALongerOne) {
    Pair pair;
    Bytes longest;
    for (std::size_t i = 0; i < UdpLink::kLongestDatagram; ++i) {
        longest.push_back(static_cast<std::uint8_t>(i * 7 / 3));
    }
    EXPECT_EQ(pair.sender->write(Bytes(UdpLink::kLongestDatagram + 1, 8)), WriteStatus::written);
    EXPECT_EQ(pair.sender->write(longest), WriteStatus::written);
    EXPECT_EQ(pair.sender->write(Bytes{1}), WriteStatus::written);
    EXPECT_EQ(pair.read(), Bytes{});
    Bytes parts;
    while (parts.size() < longest.size()) {
        Reception reception;
        ASSERT_EQ(pair.receiver->read(reception), ReadStatus::received);
        ASSERT_EQ(reception.count, kBytesPerRead);
        parts.insert(parts.end(), reception.view().begin(), reception.view().end());
        EXPECT_EQ(reception.goes_on, parts.size() < longest.size());
    }
    EXPECT_EQ(parts, longest);
    EXPECT_EQ(pair.read(), Bytes{1});
    EXPECT_TRUE(pair.is_empty());
}

TEST(UdpLink, DiscardsTheRestOfADatagramToo) {
    Pair pair;
    EXPECT_EQ(pair.sender->write(Bytes(kBytesPerRead + 1, 8)), WriteStatus::written);
    EXPECT_EQ(pair.read().size(), kBytesPerRead);
    pair.receiver->discard_unread();
    EXPECT_TRUE(pair.is_empty());
}

TEST(UdpLink, ReadsTheConfiguredSenderOnly) {
    for (const std::string host : {"127.0.0.1", "[::1]"}) {
        const std::string address = free_address(host);
        const auto wanted = UdpLink::open(address, SettingScope::input, host);
        ASSERT_TRUE(wanted) << wanted.error();
        const auto sender = UdpLink::open(address, SettingScope::output);
        EXPECT_EQ((*sender)->write(Bytes{1, 2}), WriteStatus::written);
        Reception reception;
        EXPECT_EQ((*wanted)->read(reception), ReadStatus::received);
        EXPECT_EQ(reception.count, 2U) << host;
    }
    // 127.0.0.1 sends, and another loopback address is expected.
    const std::string address = free_address();
    const auto strict = UdpLink::open(address, SettingScope::input, "127.0.0.2");
    const auto stranger = UdpLink::open(address, SettingScope::output);
    EXPECT_EQ((*stranger)->write(Bytes{1, 2}), WriteStatus::written);
    Reception reception;
    EXPECT_EQ((*strict)->read(reception), ReadStatus::received);
    EXPECT_EQ(reception.count, 0U);
    EXPECT_EQ((*strict)->read(reception), ReadStatus::nothing);
}

TEST(UdpLink, SendsAlthoughNobodyReceives) {
    const auto sender = UdpLink::open(free_address(), SettingScope::output);
    ASSERT_TRUE(sender) << sender.error();
    for (int i = 0; i < 3; ++i) {
        EXPECT_EQ((*sender)->write(Bytes{1}), WriteStatus::written);
    }
}

TEST(UdpLink, IsUnavailableWhereTheNetworkRefuses) {
    // A broadcast, which this socket may not send.
    const auto sender = UdpLink::open("255.255.255.255:5501", SettingScope::output);
    ASSERT_TRUE(sender) << sender.error();
    EXPECT_EQ((*sender)->write(Bytes{1}), WriteStatus::unavailable);
}

TEST(UdpLink, KeepsOnlyTheDatagramsOfAShortTime) {
    Pair pair;
    for (int i = 0; i < 1000; ++i) {
        EXPECT_EQ(pair.sender->write(Bytes(32, 9)), WriteStatus::written);
    }
    int kept = 0;
    Reception reception;
    while (pair.receiver->read(reception) == ReadStatus::received) {
        ++kept;
    }
    EXPECT_GT(kept, 8);
    EXPECT_LT(kept, 64) << "more than the loop reads at one wake-up";
}

TEST(UdpLink, DiscardsWhatWaits) {
    Pair pair;
    pair.sender->write(Bytes{1});
    pair.sender->write(Bytes{2});
    pair.receiver->discard_unread();
    EXPECT_TRUE(pair.is_empty());
}

TEST(UdpLink, SaysThatAnotherProgramReceivesThere) {
    Pair pair;
    const auto second = UdpLink::open(pair.address, SettingScope::input);
    ASSERT_FALSE(second);
    EXPECT_EQ(second.error(),
              pair.address + ": another program receives there; stop it, or choose another port");
}

TEST(UdpLink, IsMissingWhereNoInterfaceHasTheAddress) {
    // A range for documentation (RFC 5737).
    const std::string elsewhere = "192.0.2.7:5501";
    const auto link = UdpLink::open(elsewhere, SettingScope::input);
    ASSERT_FALSE(link);
    EXPECT_TRUE(link.error().starts_with(elsewhere + ": no interface of this machine has"));
    EXPECT_TRUE(UdpLink::is_missing(elsewhere));
    EXPECT_FALSE(UdpLink::is_missing(Pair().address)) << "in use is not missing";
    EXPECT_FALSE(UdpLink::is_missing("nonsense"));
}

TEST(UdpAddress, IsAnAddressInDigitsWithAPort) {
    for (const char* good : {"127.0.0.1:1", "0.0.0.0:65535", "[::1]:5501", "[fe80::1]:7"}) {
        EXPECT_TRUE(parse_udp_address(good)) << good;
    }
    for (const char* bad :
         {"", ":", "127.0.0.1", "127.0.0.1:", "127.0.0.1:0", "127.0.0.1:65536", "127.0.0.1:5x",
          "127.0.0.1:-1", "localhost:5501", "::1:5501", "[::1]", "[::1:5501", "127.0.0.1 :5501",
          "1.2.3:4", "[]:1", "[::1x:5501", "x::1]:5501"}) {
        EXPECT_FALSE(parse_udp_address(bad)) << bad;
    }
}

TEST(UdpAddress, SaysWhatIsWrong) {
    const std::map<std::string, std::string> reasons{
        {"127.0.0.1:70000", "port 70000 is out of range"},
        {"127.0.0.1:0", "port 0 is out of range"},
        {"127.0.0.1:-1", "port -1 is out of range"},
        {"127.0.0.1:99999999999", "port 99999999999 is out of range"},
        {"127.0.0.1:5x", "port 5x is not a number"},
        {"127.0.0.1:x5", "port x5 is not a number"},
        {"127.0.0.1:-x1", "port -x1 is not a number"},
        {"::1", "an address of IP version 6 stands in brackets"},
        {"127.0.0.1", "the port is missing"},
        {"127.0.0.1:", "the port is missing"},
        {"[::1]", "the port is missing"},
        {"::1:5501", "an address of IP version 6 stands in brackets"},
        {"localhost:5501", "localhost is not an IP address in digits"},
        {"udp://127.0.0.1:5501", "udp://127.0.0.1 is not an IP address in digits"},
    };
    for (const auto& [address, reason] : reasons) {
        const auto parsed = parse_udp_address(address);
        ASSERT_FALSE(parsed) << address;
        EXPECT_EQ(parsed.error(), reason);
    }
}

TEST(UdpAddress, KnowsWhatOnlyThisMachineReaches) {
    for (const char* inside : {"127.0.0.1:5501", "127.255.255.254:5501", "[::1]:5501"}) {
        EXPECT_TRUE(parse_udp_address(inside)->loopback) << inside;
    }
    for (const char* outside : {"0.0.0.0:5501", "126.0.0.1:5501", "128.0.0.1:5501", "[::]:5501",
                                "[::ffff:127.0.0.1]:5501"}) {
        EXPECT_FALSE(parse_udp_address(outside)->loopback) << outside;
    }
}

}  // namespace
}  // namespace tribus::udp_link_test
