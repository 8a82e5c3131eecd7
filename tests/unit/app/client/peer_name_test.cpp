#include "app/client/peer_name.h"

#include <gtest/gtest.h>

#include <string>

namespace tribus::peer_name_test {
namespace {

std::string named(const std::string& address) {
    return peer_name(address).value_or("none");
}

TEST(PeerName, IsAnIpv4AddressHoweverItIsWritten) {
    EXPECT_EQ(named("192.0.2.7"), "192.0.2.7");
    EXPECT_EQ(named("::ffff:192.0.2.7"), "192.0.2.7");
    EXPECT_EQ(named("::ffff:c000:207"), "192.0.2.7");
}

TEST(PeerName, IsTheNetworkOfAnIpv6Address) {
    EXPECT_EQ(named("2001:db8:1:2:f3ff:4:5:6"), "2001:db8:1:2::/64");
    EXPECT_EQ(named("2001:DB8:1:2::9"), "2001:db8:1:2::/64");
    EXPECT_EQ(named("2001:db8:1:3::9"), "2001:db8:1:3::/64");
    EXPECT_EQ(named("::1"), "::1");
}

TEST(PeerName, IsNoneForWhatIsNoAddress) {
    for (const std::string text :
         {"", "boat", "192.0.2.7:80", "[::1]", "1.2.3", "1.2.3.4\n", ":"}) {
        EXPECT_EQ(named(text), "none") << text;
    }
}

TEST(PeerName, SaysWhoIsOnThisMachine) {
    for (const char* own : {"user 1000", "127.0.0.1", "127.9.9.9", "::1"}) {
        EXPECT_TRUE(is_on_this_machine(own)) << own;
    }
    for (const char* other : {"192.0.2.7", "12.7.0.1", "2001:db8:1:2::/64", "::/64"}) {
        EXPECT_FALSE(is_on_this_machine(other)) << other;
    }
}

}  // namespace
}  // namespace tribus::peer_name_test
