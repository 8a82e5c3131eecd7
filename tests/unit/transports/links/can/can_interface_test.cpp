#include "transports/links/can/can_interface.h"

#include <gtest/gtest.h>
#include <linux/can/netlink.h>
#include <linux/if_arp.h>
#include <linux/if_link.h>
#include <linux/rtnetlink.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tests/support/netlink_messages.h"

namespace tribus::can_interface_test {
namespace {

using namespace test::netlink;

// Flags of an interface from linux/if.h, which conflicts with the C library's <net/if.h>.
constexpr std::uint32_t kUp = 0x1;
constexpr std::uint32_t kRunning = 0x40;
constexpr std::uint32_t kNoArp = 0x80;
constexpr std::uint32_t kLowerUp = 0x10000;
constexpr std::uint32_t kEcho = 0x40000;

Bytes link_message(std::uint32_t flags, const Bytes& attributes,
                   unsigned short hardware = ARPHRD_CAN) {
    ifinfomsg link{};
    link.ifi_type = hardware;
    link.ifi_index = 7;
    link.ifi_flags = flags;
    return message(RTM_NEWLINK, joined({bytes_of(link), attributes}));
}

/// With these attributes of its controller.
Bytes of_controller(const Bytes& attributes) {
    return link_message(0,
                        attribute(IFLA_LINKINFO, joined({attribute(IFLA_INFO_KIND, bytes_of("can")),
                                                         attribute(IFLA_INFO_DATA, attributes)})));
}

Bytes controller_message() {
    can_bittiming timing{};
    timing.bitrate = 500000;
    timing.sample_point = 875;
    can_bittiming data_timing{};
    data_timing.bitrate = 4000000;
    const can_ctrlmode modes{.mask = 0xFFFFFFFF, .flags = CAN_CTRLMODE_FD | CAN_CTRLMODE_ONE_SHOT};
    const Bytes data = joined(
        {attribute(IFLA_CAN_BITTIMING, bytes_of(timing)),
         attribute(IFLA_CAN_DATA_BITTIMING, bytes_of(data_timing)),
         attribute(IFLA_CAN_STATE, bytes_of<std::uint32_t>(CAN_STATE_ERROR_PASSIVE)),
         attribute(IFLA_CAN_CTRLMODE, bytes_of(modes)),
         attribute(IFLA_CAN_RESTART_MS, bytes_of<std::uint32_t>(100)),
         attribute(IFLA_CAN_BERR_COUNTER, bytes_of(can_berr_counter{.txerr = 128, .rxerr = 3}))});
    return link_message(
        kUp | kLowerUp | kEcho,
        joined({attribute(IFLA_IFNAME, bytes_of("can0")),
                attribute(IFLA_MTU, bytes_of<std::uint32_t>(72)),
                attribute(IFLA_TXQLEN, bytes_of<std::uint32_t>(10)),
                attribute(IFLA_LINKINFO, joined({attribute(IFLA_INFO_KIND, bytes_of("can")),
                                                 attribute(IFLA_INFO_DATA, data)}))}));
}

// Answer of Linux 6.1 after `ip link add vcan0 mtu 72 type vcan; ip link set vcan0 up`, shortened
// to four attributes.
TEST(CanInterfaceParsing, ReadsALiteralMessage) {
    constexpr std::uint8_t kMessage[] = {
        0x4C, 0x00, 0x00, 0x00, 0x10, 0x00, 0x00, 0x00,  // 76 bytes, RTM_NEWLINK
        0x01, 0x00, 0x00, 0x00, 0x7C, 0x00, 0x00, 0x00,  //
        0x00, 0x00, 0x18, 0x01, 0x04, 0x00, 0x00, 0x00,  // ARPHRD_CAN, index 4
        0xC1, 0x00, 0x01, 0x00, 0x00, 0x00, 0x00, 0x00,  // up, running, no ARP, lower up
        0x0A, 0x00, 0x03, 0x00, 0x76, 0x63, 0x61, 0x6E, 0x30, 0x00, 0x00, 0x00,  // vcan0
        0x08, 0x00, 0x0D, 0x00, 0xE8, 0x03, 0x00, 0x00,                          // 1000 frames
        0x08, 0x00, 0x04, 0x00, 0x48, 0x00, 0x00, 0x00,                          // MTU 72
        0x10, 0x00, 0x12, 0x00, 0x09, 0x00, 0x01, 0x00,                          // vcan
        0x76, 0x63, 0x61, 0x6E, 0x00, 0x00, 0x00, 0x00};
    const auto interface = parse_link_message(std::as_bytes(std::span(kMessage)));
    ASSERT_TRUE(interface);
    EXPECT_EQ(interface->name, "vcan0");
    EXPECT_EQ(interface->kind, "vcan");
    EXPECT_EQ(interface->index, 4U);
    EXPECT_TRUE(interface->is_can);
    EXPECT_TRUE(interface->up);
    EXPECT_TRUE(interface->lower_up);
    EXPECT_FALSE(interface->echo);
    EXPECT_EQ(interface->mtu, 72U);
    EXPECT_EQ(interface->queue_length, 1000U);
    EXPECT_EQ(interface->bit_rate, std::nullopt);
    EXPECT_EQ(interface->restart_ms, std::nullopt);
}

TEST(CanInterfaceParsing, ReadsAllOfAController) {
    const auto interface = parse_link_message(controller_message());
    ASSERT_TRUE(interface);
    EXPECT_EQ(interface->kind, "can");
    EXPECT_TRUE(interface->echo);
    EXPECT_EQ(interface->bit_rate, 500000U);
    EXPECT_EQ(interface->sample_point_permille, 875U);
    EXPECT_EQ(interface->data_bit_rate, 4000000U);
    EXPECT_EQ(interface->restart_ms, 100U);
    EXPECT_EQ(interface->state, CanControllerState::passive);
    EXPECT_EQ(interface->transmit_errors, 128);
    EXPECT_EQ(interface->receive_errors, 3);
    EXPECT_TRUE(interface->fd);
    EXPECT_TRUE(interface->one_shot);
    EXPECT_FALSE(interface->listen_only);
}

TEST(CanInterfaceParsing, KnowsOtherInterfacesByTheirHardware) {
    constexpr unsigned short kEthernet = 1;
    const auto interface =
        parse_link_message(link_message(kUp, attribute(IFLA_IFNAME, bytes_of("eth0")), kEthernet));
    ASSERT_TRUE(interface);
    EXPECT_FALSE(interface->is_can);
}

TEST(CanInterfaceParsing, SurvivesMessagesCutAnywhere) {
    const Bytes whole = controller_message();
    for (std::size_t size = 0; size < whole.size(); ++size) {
        EXPECT_EQ(parse_link_message(std::span(whole).first(size)), std::nullopt) << size;
    }
}

TEST(CanInterfaceParsing, SurvivesAnyChangedByte) {
    const Bytes whole = controller_message();
    for (std::size_t place = 0; place < whole.size(); ++place) {
        for (const unsigned value : {0x00U, 0x01U, 0x7FU, 0xFFU}) {
            Bytes changed = whole;
            changed[place] = static_cast<std::byte>(value);
            parse_link_message(changed);
        }
    }
}

struct Mode {
    std::uint32_t flag;
    bool CanInterface::*shown;
};

/// Of a controller with this one mode, and of an interface with this one flag.
class CanInterfaceFlag : public ::testing::TestWithParam<Mode> {
  protected:
    static Bytes with_mode(std::uint32_t flags) {
        const can_ctrlmode modes{.mask = 0xFFFFFFFF, .flags = flags};
        return of_controller(attribute(IFLA_CAN_CTRLMODE, bytes_of(modes)));
    }
    static void expect_only(bool CanInterface::*shown, const std::vector<bool CanInterface::*>& all,
                            const Bytes& whole) {
        const auto interface = parse_link_message(whole);
        ASSERT_TRUE(interface);
        for (bool CanInterface::*const each : all) {
            EXPECT_EQ((*interface).*each, each == shown);
        }
    }
};

class CanControllerMode : public CanInterfaceFlag {};

TEST_P(CanControllerMode, IsShownByItself) {
    expect_only(GetParam().shown,
                {&CanInterface::loopback, &CanInterface::listen_only, &CanInterface::one_shot,
                 &CanInterface::fd, &CanInterface::bus_error_reporting},
                with_mode(GetParam().flag));
}

INSTANTIATE_TEST_SUITE_P(Each, CanControllerMode,
                         testing::Values(Mode{CAN_CTRLMODE_LOOPBACK, &CanInterface::loopback},
                                         Mode{CAN_CTRLMODE_LISTENONLY, &CanInterface::listen_only},
                                         Mode{CAN_CTRLMODE_ONE_SHOT, &CanInterface::one_shot},
                                         Mode{CAN_CTRLMODE_FD, &CanInterface::fd},
                                         Mode{CAN_CTRLMODE_BERR_REPORTING,
                                              &CanInterface::bus_error_reporting},
                                         Mode{CAN_CTRLMODE_3_SAMPLES, nullptr}));

class CanInterfaceFlagOfTheKernel : public CanInterfaceFlag {};

TEST_P(CanInterfaceFlagOfTheKernel, IsShownByItself) {
    expect_only(
        GetParam().shown,
        {&CanInterface::up, &CanInterface::lower_up, &CanInterface::running, &CanInterface::echo},
        link_message(GetParam().flag, {}));
}

INSTANTIATE_TEST_SUITE_P(Each, CanInterfaceFlagOfTheKernel,
                         testing::Values(Mode{kUp, &CanInterface::up},
                                         Mode{kLowerUp, &CanInterface::lower_up},
                                         Mode{kRunning, &CanInterface::running},
                                         Mode{kEcho, &CanInterface::echo}, Mode{kNoArp, nullptr}));

TEST(CanInterfaceParsing, KnowsEachStateOfAControllerAndNoOther) {
    const auto state_of = [](std::uint32_t number) {
        return parse_link_message(of_controller(attribute(IFLA_CAN_STATE, bytes_of(number))))
            ->state;
    };
    EXPECT_EQ(state_of(0), CanControllerState::active);
    EXPECT_EQ(state_of(1), CanControllerState::warning);
    EXPECT_EQ(state_of(3), CanControllerState::bus_off);
    EXPECT_EQ(state_of(4), CanControllerState::stopped);
    EXPECT_EQ(state_of(5), CanControllerState::sleeping);
    EXPECT_EQ(state_of(6), std::nullopt);
}

TEST(CanInterfaceParsing, ABitRateOfZeroIsNone) {
    const auto interface = parse_link_message(
        of_controller(joined({attribute(IFLA_CAN_BITTIMING, bytes_of(can_bittiming{})),
                              attribute(IFLA_CAN_DATA_BITTIMING, bytes_of(can_bittiming{}))})));
    ASSERT_TRUE(interface);
    EXPECT_EQ(interface->bit_rate, std::nullopt);
    EXPECT_EQ(interface->data_bit_rate, std::nullopt);
}

TEST(CanInterfaceParsing, TakesTheBitRateOfDataForNoOther) {
    can_bittiming timing{};
    timing.bitrate = 2000000;
    timing.sample_point = 750;
    const auto interface =
        parse_link_message(of_controller(attribute(IFLA_CAN_DATA_BITTIMING, bytes_of(timing))));
    ASSERT_TRUE(interface);
    EXPECT_EQ(interface->data_bit_rate, 2000000U);
    EXPECT_EQ(interface->bit_rate, std::nullopt);
    EXPECT_EQ(interface->sample_point_permille, std::nullopt);
}

TEST(CanInterfaceParsing, TakesNoValueOfAnAttributeThatIsTooShort) {
    const Bytes three(3);
    const auto interface = parse_link_message(of_controller(
        joined({attribute(IFLA_CAN_BITTIMING, three), attribute(IFLA_CAN_STATE, three),
                attribute(IFLA_CAN_CTRLMODE, three), attribute(IFLA_CAN_RESTART_MS, three),
                attribute(IFLA_CAN_BERR_COUNTER, three)})));
    ASSERT_TRUE(interface);
    EXPECT_EQ(interface->bit_rate, std::nullopt);
    EXPECT_EQ(interface->state, std::nullopt);
    EXPECT_EQ(interface->restart_ms, std::nullopt);
    EXPECT_EQ(interface->transmit_errors, std::nullopt);
    EXPECT_EQ(interface->receive_errors, std::nullopt);
    const auto nameless = parse_link_message(
        link_message(0, joined({attribute(IFLA_MTU, three), attribute(IFLA_TXQLEN, three)})));
    ASSERT_TRUE(nameless);
    EXPECT_EQ(nameless->mtu, 0U);
    EXPECT_EQ(nameless->queue_length, 0U);
}

/// Its attributes have the same numbers and other meanings.
TEST(CanInterfaceParsing, TakesWhatAControllerSaysFromNoOtherKind) {
    const Bytes info = joined(
        {attribute(IFLA_INFO_KIND, bytes_of("vxcan")),
         attribute(IFLA_INFO_DATA, attribute(IFLA_CAN_RESTART_MS, bytes_of<std::uint32_t>(100)))});
    const auto interface = parse_link_message(link_message(0, attribute(IFLA_LINKINFO, info)));
    ASSERT_TRUE(interface);
    EXPECT_EQ(interface->kind, "vxcan");
    EXPECT_EQ(interface->restart_ms, std::nullopt);
}

/// The kernel marks that an attribute contains others.
TEST(CanInterfaceParsing, KnowsAnAttributeWithFlags) {
    const auto interface = parse_link_message(link_message(
        0,
        attribute(IFLA_LINKINFO | 0x8000U, attribute(IFLA_INFO_KIND | 0x4000U, bytes_of("can")))));
    ASSERT_TRUE(interface);
    EXPECT_EQ(interface->kind, "can");
}

TEST(CanInterfaceParsing, TakesNothingFromBehindTheMessage) {
    const Bytes two = joined({link_message(0, attribute(IFLA_IFNAME, bytes_of("can0"))),
                              attribute(IFLA_MTU, bytes_of<std::uint32_t>(72))});
    const auto interface = parse_link_message(two);
    ASSERT_TRUE(interface);
    EXPECT_EQ(interface->name, "can0");
    EXPECT_EQ(interface->mtu, 0U);
}

TEST(CanInterfaceParsing, PassesAnEmptyAttributeOver) {
    const auto interface = parse_link_message(link_message(
        0,
        joined({attribute(IFLA_IFALIAS, {}), attribute(IFLA_MTU, bytes_of<std::uint32_t>(72))})));
    ASSERT_TRUE(interface);
    EXPECT_EQ(interface->mtu, 72U);
}

TEST(CanInterfaceParsing, StopsAtADamagedAttribute) {
    for (const unsigned short length : std::initializer_list<unsigned short>{0, 3, 200}) {
        rtattr damaged{};
        damaged.rta_len = length;
        const auto interface = parse_link_message(
            link_message(0, joined({attribute(IFLA_IFNAME, bytes_of("can0")), bytes_of(damaged),
                                    attribute(IFLA_MTU, bytes_of<std::uint32_t>(72))})));
        ASSERT_TRUE(interface) << length;
        EXPECT_EQ(interface->name, "can0") << length;
        EXPECT_EQ(interface->mtu, 0U) << length;
    }
}

TEST(CanInterfaceParsing, AMessageIsAsLongAsItSaysAndHasAtLeastItsFixedPart) {
    constexpr std::size_t kFixedPart = 32;
    for (std::uint32_t length = 0; length <= kFixedPart; ++length) {
        Bytes whole = controller_message();
        std::memcpy(whole.data(), &length, sizeof length);
        EXPECT_EQ(parse_link_message(whole).has_value(), length == kFixedPart) << length;
    }
}

TEST(CanInterfaceParsing, ReadsNoMessageOfAnotherKind) {
    Bytes whole = controller_message();
    for (const std::uint16_t type : {RTM_DELLINK, RTM_GETLINK, RTM_NEWADDR}) {
        std::memcpy(whole.data() + offsetof(nlmsghdr, nlmsg_type), &type, sizeof type);
        EXPECT_FALSE(parse_link_message(whole)) << type;
    }
}

}  // namespace
}  // namespace tribus::can_interface_test
