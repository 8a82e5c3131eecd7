#include "transports/links/can/can_netlink.h"

#include <linux/if_arp.h>
#include <linux/if_link.h>
#include <linux/rtnetlink.h>

#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/netlink_messages.h"

namespace tribus::test::can_netlink_test {
namespace {

using namespace netlink;
using netlink::Bytes;

Bytes literal(std::initializer_list<unsigned> values) {
    Bytes bytes;
    for (const unsigned value : values) {
        bytes.push_back(static_cast<std::byte>(value));
    }
    return bytes;
}

TEST(NetlinkRequest, AsksForAnInterfaceByItsName) {
    EXPECT_EQ(request_of_interface("can0"),
              literal({0x2C, 0, 0, 0, 0x12, 0,   0x01, 0,  // 44 bytes, RTM_GETLINK, a request
                       0,    0, 0, 0, 0,    0,   0,    0,  //
                       0,    0, 0, 0, 0,    0,   0,    0,  // an interface
                       0,    0, 0, 0, 0,    0,   0,    0,  //
                       9,    0, 3, 0, 'c',  'a', 'n',  '0', 0, 0, 0, 0}));
}

TEST(NetlinkRequest, HasNoPaddingBehindANameThatNeedsNone) {
    const NetlinkRequest request = request_of_interface("can");
    EXPECT_EQ(Bytes(request.begin() + 32, request.end()), literal({8, 0, 3, 0, 'c', 'a', 'n', 0}));
    EXPECT_EQ(request[0], std::byte{0x28});
}

TEST(NetlinkRequest, AsksForAllInterfaces) {
    EXPECT_EQ(request_of_all_interfaces(),
              literal({0x20, 0, 0, 0, 0x12, 0, 0x01, 0x03,  // 32 bytes, RTM_GETLINK, a dump
                       0,    0, 0, 0, 0,    0, 0,    0,     //
                       0,    0, 0, 0, 0,    0, 0,    0,     //
                       0,    0, 0, 0, 0,    0, 0,    0}));
}

/// As `ip link set can0 type can restart` does.
TEST(NetlinkRequest, RestartsAController) {
    EXPECT_EQ(request_of_restart("can0"),
              literal({0x44, 0, 0,  0, 0x10, 0,   0x05, 0,  // 68 bytes, RTM_NEWLINK, with an answer
                       0,    0, 0,  0, 0,    0,   0,    0,  //
                       0,    0, 0,  0, 0,    0,   0,    0,  //
                       0,    0, 0,  0, 0,    0,   0,    0,  //
                       9,    0, 3,  0, 'c',  'a', 'n',  '0', 0, 0, 0, 0,  // its name
                       0x18, 0, 18, 0,                                    // what follows in one
                       7,    0, 1,  0, 'c',  'a', 'n',  0,                // its kind
                       12,   0, 2,  0,                                    // of the controller:
                       8,    0, 7,  0, 1,    0,   0,    0}));             // restart
}

TEST(NetlinkName, HasOneTo15Letters) {
    EXPECT_FALSE(is_name_of_interface(""));
    EXPECT_TRUE(is_name_of_interface("c"));
    EXPECT_TRUE(is_name_of_interface("fifteen-letters"));
    EXPECT_FALSE(is_name_of_interface("sixteen-letters-"));
}

Bytes interface_message(const char* name, std::uint16_t flags = 0) {
    ifinfomsg link{};
    link.ifi_type = ARPHRD_CAN;
    return message(RTM_NEWLINK, joined({bytes_of(link), attribute(IFLA_IFNAME, bytes_of(name))}),
                   flags);
}

/// The result of reading a datagram.
struct Taken {
    tl::expected<bool, int> more;
    std::vector<std::string> names{};
};

Taken take_all(const Bytes& datagram) {
    std::vector<CanInterface> found;
    Taken taken{.more = take_messages(datagram, found)};
    for (const CanInterface& interface : found) {
        taken.names.push_back(interface.name);
    }
    return taken;
}

using Names = std::vector<std::string>;

TEST(NetlinkAnswer, OneMessageByItselfIsAll) {
    const Taken taken = take_all(interface_message("can0"));
    EXPECT_EQ(taken.more, false);
    EXPECT_EQ(taken.names, Names{"can0"});
}

TEST(NetlinkAnswer, OneOfManyMessagesIsFollowedByMore) {
    const Taken taken = take_all(
        joined({interface_message("can0", NLM_F_MULTI), interface_message("can1", NLM_F_MULTI)}));
    EXPECT_EQ(taken.more, true);
    EXPECT_EQ(taken.names, (Names{"can0", "can1"}));
    EXPECT_EQ(
        take_all(joined({interface_message("can0", NLM_F_MULTI), interface_message("can1")})).more,
        true);
}

TEST(NetlinkAnswer, EndsWithTheMessageThatSaysSo) {
    for (const std::size_t payload : {0U, 4U}) {
        const Taken taken = take_all(
            joined({interface_message("can0", NLM_F_MULTI),
                    message(NLMSG_DONE, Bytes(payload), NLM_F_MULTI), interface_message("can1")}));
        EXPECT_EQ(taken.more, false) << payload;
        EXPECT_EQ(taken.names, Names{"can0"}) << payload;
    }
}

TEST(NetlinkAnswer, EndsWhereADatagramHasNothingElseThanItsEnd) {
    const Taken taken = take_all(
        joined({interface_message("can0", NLM_F_MULTI), message(NLMSG_DONE, {}, NLM_F_MULTI)}));
    EXPECT_EQ(taken.more, false);
}

TEST(NetlinkAnswer, PassesMessagesOfOtherKindsOver) {
    const Taken taken =
        take_all(joined({message(RTM_NEWADDR, Bytes(16)), interface_message("can0")}));
    EXPECT_EQ(taken.more, false);
    EXPECT_EQ(taken.names, Names{"can0"});
}

TEST(NetlinkAnswer, MessagesBeginAtMultiplesOfFourBytes) {
    const Taken taken =
        take_all(joined({padded(message(RTM_NEWADDR, Bytes(13))), interface_message("can0")}));
    EXPECT_EQ(taken.names, Names{"can0"});
    EXPECT_EQ(take_all(message(RTM_NEWADDR, Bytes(13))).more, false) << "at the end they may miss";
}

TEST(NetlinkAnswer, IsTheKernelsError) {
    const auto answer = [](int error) { return take_all(message(NLMSG_ERROR, bytes_of(error))); };
    EXPECT_EQ(answer(-ENODEV).more, tl::unexpected(ENODEV));
    EXPECT_EQ(answer(-EPERM).more, tl::unexpected(EPERM));
    EXPECT_EQ(answer(0).more, false) << "an acknowledgement";
}

TEST(NetlinkAnswer, ThatIsDamagedIsAnErrorOfTheProtocol) {
    EXPECT_EQ(take_all(message(NLMSG_ERROR, Bytes(3))).more, tl::unexpected(EPROTO));
    for (const std::uint32_t length : {0U, 15U, 100U}) {
        Bytes damaged = interface_message("can0");
        std::memcpy(damaged.data(), &length, sizeof length);
        const Taken taken = take_all(damaged);
        EXPECT_EQ(taken.more, tl::unexpected(EPROTO)) << length;
        EXPECT_EQ(taken.names, Names{}) << length;
    }
}

TEST(NetlinkAnswer, WithoutAMessageIsAll) {
    EXPECT_EQ(take_all({}).more, false);
    EXPECT_EQ(take_all(Bytes(15)).more, false);
}

CanInterface named(const char* name, bool is_can) {
    CanInterface interface;
    interface.name = name;
    interface.is_can = is_can;
    return interface;
}

TEST(ExistingCanInterfaces, AreNamedWithoutAnyOther) {
    const std::vector<CanInterface> all{named("lo", false), named("can0", true),
                                        named("eth0", false), named("can1", true)};
    EXPECT_EQ(existing_can_interfaces(all), "the CAN interfaces are: can0, can1");
}

TEST(ExistingCanInterfaces, AreHadInTheseWaysIfThereAreNone) {
    const std::vector<CanInterface> all{named("lo", false)};
    EXPECT_EQ(existing_can_interfaces(all),
              "there is no CAN interface: a controller appears when its driver is loaded (on small "
              "boards an overlay enables it); `modprobe vcan; ip link add vcan0 type vcan; ip link "
              "set vcan0 up` makes a virtual one");
}

struct Problem {
    int error;
    std::string_view text;
};

class AskingProblem : public ::testing::TestWithParam<Problem> {};

TEST_P(AskingProblem, IsTold) {
    EXPECT_EQ(asking_problem(GetParam().error), GetParam().text);
}

#define TRIBUS_NOT_PERMITTED                                                                    \
    "not permitted to read network interfaces from the kernel (AF_NETLINK; a service needs it " \
    "in RestrictAddressFamilies): "
INSTANTIATE_TEST_SUITE_P(
    Each, AskingProblem,
    testing::Values(Problem{EAFNOSUPPORT,
                            TRIBUS_NOT_PERMITTED "Address family not supported by protocol"},
                    Problem{EACCES, TRIBUS_NOT_PERMITTED "Permission denied"},
                    Problem{EPERM, TRIBUS_NOT_PERMITTED "Operation not permitted"},
                    Problem{ENOBUFS, "cannot read it from the kernel: No buffer space available"}));

class RestartProblem : public ::testing::TestWithParam<Problem> {};

TEST_P(RestartProblem, IsToldWithWhatToDo) {
    EXPECT_EQ(restart_problem("can0", GetParam().error), GetParam().text);
}

INSTANTIATE_TEST_SUITE_P(
    Each, RestartProblem,
    testing::Values(
        Problem{EPERM,
                "can0: not permitted to restart the controller: give the program CAP_NET_ADMIN, or "
                "set restart-ms"},
        Problem{EINVAL, "can0: it cannot be restarted now: it is down, or not in bus-off"},
        Problem{EBUSY, "can0: it cannot be restarted now: it is down, or not in bus-off"},
        Problem{EOPNOTSUPP,
                "can0: its driver has no restart: `ip link set can0 down`, `ip link set can0 up`"},
        Problem{ENODEV, "can0: cannot restart the controller: No such device"}));

}  // namespace
}  // namespace tribus::test::can_netlink_test
