#include "transports/links/can/interface_change.h"

#include <linux/if_link.h>
#include <linux/rtnetlink.h>
#include <sys/socket.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/netlink_messages.h"

namespace tribus::test::interface_change_test {
namespace {

using namespace netlink;
using netlink::Bytes;

// Flags of an interface from linux/if.h.
constexpr unsigned kUp = 0x1;
constexpr unsigned kRunning = 0x40;
constexpr unsigned kNoArp = 0x80;

Bytes change(unsigned flags, std::uint16_t type = RTM_NEWLINK, std::uint8_t family = AF_UNSPEC) {
    ifinfomsg link{};
    link.ifi_family = family;
    link.ifi_index = 7;
    link.ifi_flags = flags;
    return message(type, joined({bytes_of(link), attribute(IFLA_MTU, bytes_of<std::uint32_t>(16)),
                                 attribute(IFLA_IFNAME, bytes_of("can0"))}));
}

TEST(InterfaceChange, TellsWhichInterfaceItIs) {
    const Bytes bytes = change(kUp);
    const auto read = parse_interface_change(bytes);
    ASSERT_TRUE(read);
    EXPECT_EQ(read->index, 7U);
    EXPECT_EQ(read->name, "can0");
    EXPECT_FALSE(read->gone);
}

TEST(InterfaceChange, TellsThatAnInterfaceIsGone) {
    const Bytes bytes = change(0, RTM_DELLINK);
    const auto read = parse_interface_change(bytes);
    ASSERT_TRUE(read);
    EXPECT_EQ(read->name, "can0");
    EXPECT_TRUE(read->gone);
}

struct Flags {
    unsigned flags;
    bool up;
    bool running;
};

class InterfaceChangeWith : public ::testing::TestWithParam<Flags> {};

TEST_P(InterfaceChangeWith, TellsThatItIsUpAndThatItHasACarrier) {
    const auto read = parse_interface_change(change(GetParam().flags));
    ASSERT_TRUE(read);
    EXPECT_EQ(read->up, GetParam().up);
    EXPECT_EQ(read->running, GetParam().running);
}

INSTANTIATE_TEST_SUITE_P(Flags, InterfaceChangeWith,
                         testing::Values(Flags{0, false, false}, Flags{kNoArp, false, false},
                                         Flags{kUp, true, false}, Flags{kRunning, false, true},
                                         Flags{kUp | kRunning, true, true}));

TEST(InterfaceChange, IsInNoMessageOfABridgeOrOfAnotherKind) {
    EXPECT_FALSE(parse_interface_change(change(kUp, RTM_NEWLINK, AF_BRIDGE)));
    EXPECT_FALSE(parse_interface_change(change(kUp, RTM_GETLINK)));
    EXPECT_FALSE(parse_interface_change(change(kUp, NLMSG_DONE)));
}

TEST(InterfaceChange, IsReadOfAMessageWhoseEndIsMissing) {
    const Bytes whole = change(kUp);
    constexpr std::size_t kFixedPart = 32;
    for (std::size_t size = 0; size < whole.size(); ++size) {
        const auto read = parse_interface_change(std::span(whole).first(size));
        ASSERT_EQ(read.has_value(), size >= kFixedPart) << size;
        if (read) {
            EXPECT_EQ(read->index, 7U) << size;
            // Only padding is missing where 9 bytes of its attribute are there.
            EXPECT_EQ(read->name, size >= kFixedPart + 8 + 9 ? "can0" : "") << size;
        }
    }
}

TEST(InterfaceChange, HasANameWithoutAnEndThatIsAsLongAsItsAttribute) {
    const Bytes bytes = message(
        RTM_NEWLINK,
        joined({bytes_of(ifinfomsg{}), attribute(IFLA_IFNAME, {std::byte{'c'}, std::byte{'4'}})}));
    const auto read = parse_interface_change(bytes);
    ASSERT_TRUE(read);
    EXPECT_EQ(read->name, "c4");
}

}  // namespace
}  // namespace tribus::test::interface_change_test
