#include "transports/links/can/can_interface.h"

#include <gtest/gtest.h>
#include <linux/can/netlink.h>
#include <linux/if_arp.h>
#include <linux/if_link.h>
#include <linux/rtnetlink.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace tribus::can_interface_test {
namespace {

using Bytes = std::vector<std::byte>;

// Flags of an interface from linux/if.h, which conflicts with the C library's <net/if.h>.
constexpr std::uint32_t kUp = 0x1;
constexpr std::uint32_t kLowerUp = 0x10000;
constexpr std::uint32_t kEcho = 0x40000;

template <typename T>
Bytes bytes_of(const T& value) {
    Bytes bytes(sizeof value);
    std::memcpy(bytes.data(), &value, sizeof value);
    return bytes;
}

Bytes bytes_of(const char* text) {
    Bytes bytes;
    for (const char letter : std::string_view(text)) {
        bytes.push_back(static_cast<std::byte>(letter));
    }
    bytes.push_back(std::byte{0});
    return bytes;
}

void append(Bytes& bytes, const Bytes& more) {
    std::ranges::copy(more, std::back_inserter(bytes));
}

Bytes attribute(unsigned type, const Bytes& payload) {
    rtattr head{};
    head.rta_type = static_cast<unsigned short>(type);
    head.rta_len = static_cast<unsigned short>(sizeof head + payload.size());
    Bytes bytes = bytes_of(head);
    append(bytes, payload);
    bytes.resize((bytes.size() + 3) / 4 * 4);
    return bytes;
}

Bytes joined(const std::vector<Bytes>& parts) {
    Bytes all;
    for (const Bytes& part : parts) {
        append(all, part);
    }
    return all;
}

Bytes link_message(std::uint32_t flags, const Bytes& attributes,
                   unsigned short hardware = ARPHRD_CAN) {
    ifinfomsg link{};
    link.ifi_type = hardware;
    link.ifi_index = 7;
    link.ifi_flags = flags;
    nlmsghdr head{};
    head.nlmsg_type = RTM_NEWLINK;
    head.nlmsg_len = static_cast<std::uint32_t>(sizeof head + sizeof link + attributes.size());
    return joined({bytes_of(head), bytes_of(link), attributes});
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

/// A controller that is set up well for RC.
CanInterface good_controller() {
    CanInterface interface;
    interface.name = "can0";
    interface.kind = "can";
    interface.index = 7;
    interface.is_can = true;
    interface.up = true;
    interface.lower_up = true;
    interface.echo = true;
    interface.mtu = 16;
    interface.queue_length = 10;
    interface.bit_rate = 500000;
    interface.sample_point_permille = 875;
    interface.restart_ms = 100;
    interface.state = CanControllerState::active;
    interface.transmit_errors = 0;
    interface.receive_errors = 0;
    return interface;
}

CanInterface virtual_bus() {
    CanInterface interface;
    interface.name = "vcan0";
    interface.kind = "vcan";
    interface.is_can = true;
    interface.up = true;
    interface.lower_up = true;
    interface.mtu = 72;
    return interface;
}

testing::AssertionResult advises(const CanInterface& interface, const std::string& command,
                                 bool sends = true, bool fd_wanted = false) {
    const auto sentences = advice(interface, sends, fd_wanted);
    if (sentences.size() == 1 && sentences[0].find(command) != std::string::npos) {
        return testing::AssertionSuccess();
    }
    return testing::AssertionFailure() << testing::PrintToString(sentences);
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

TEST(CanInterfaceParsing, ABitRateOfZeroIsNone) {
    const Bytes info = joined(
        {attribute(IFLA_INFO_KIND, bytes_of("can")),
         attribute(IFLA_INFO_DATA, attribute(IFLA_CAN_BITTIMING, bytes_of(can_bittiming{})))});
    const auto interface = parse_link_message(link_message(0, attribute(IFLA_LINKINFO, info)));
    ASSERT_TRUE(interface);
    EXPECT_EQ(interface->bit_rate, std::nullopt);
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

TEST(CanInterfaceAdvice, HasNothingToSayAboutAGoodController) {
    EXPECT_TRUE(advice(good_controller(), true, false).empty());
}

TEST(CanInterfaceAdvice, HasNothingToSayAboutAVirtualBus) {
    EXPECT_TRUE(advice(virtual_bus(), true, true).empty());
}

TEST(CanInterfaceAdvice, NoRestartAfterBusOff) {
    CanInterface interface = good_controller();
    interface.restart_ms = 0;
    EXPECT_TRUE(advises(interface, "`ip link set can0 type can restart-ms 100`"));
}

TEST(CanInterfaceAdvice, DownWithAndWithoutBitRate) {
    CanInterface interface = good_controller();
    interface.up = false;
    interface.lower_up = false;
    EXPECT_TRUE(advises(interface, "`ip link set can0 up`"));
    interface.bit_rate.reset();
    EXPECT_TRUE(advises(interface, "`ip link set can0 up type can bitrate 1000000`"));
}

TEST(CanInterfaceAdvice, NoCarrier) {
    CanInterface interface = virtual_bus();
    interface.lower_up = false;
    EXPECT_TRUE(advises(interface, "no carrier"));
}

TEST(CanInterfaceAdvice, BusOff) {
    CanInterface interface = good_controller();
    interface.state = CanControllerState::bus_off;
    interface.lower_up = false;
    EXPECT_TRUE(advises(interface, "`ip link set can0 type can restart`"));
}

TEST(CanInterfaceAdvice, ALongQueueWhereWeSend) {
    CanInterface interface = good_controller();
    interface.queue_length = 1000;
    EXPECT_TRUE(advises(interface, "`ip link set can0 txqueuelen 16`"));
    EXPECT_TRUE(advice(interface, false, false).empty());
}

TEST(CanInterfaceAdvice, ListenOnlyWhereWeSend) {
    CanInterface interface = good_controller();
    interface.listen_only = true;
    EXPECT_TRUE(advises(interface, "`ip link set can0 type can listen-only off`"));
    EXPECT_TRUE(advice(interface, false, false).empty());
}

TEST(CanInterfaceAdvice, LoopbackAndOneShotWhereWeSend) {
    CanInterface interface = good_controller();
    interface.one_shot = true;
    EXPECT_TRUE(advises(interface, "`ip link set can0 type can one-shot off`"));
    interface.one_shot = false;
    interface.loopback = true;
    EXPECT_TRUE(advises(interface, "`ip link set can0 type can loopback off`"));
}

TEST(CanInterfaceAdvice, FdOnAControllerNeedsItsModeAndOnAVirtualBusTheMtu) {
    EXPECT_TRUE(advises(good_controller(), "bitrate 500000 dbitrate 4000000 fd on`", true, true));
    CanInterface interface = virtual_bus();
    interface.mtu = 16;
    EXPECT_TRUE(advises(interface, "`ip link set vcan0 mtu 72`", true, true));
    EXPECT_EQ(fd_problem(virtual_bus()), std::nullopt);
}

TEST(CanInterfaceSummary, IsOneLineWithAllThatIsKnown) {
    CanInterface interface = good_controller();
    interface.data_bit_rate = 4000000;
    interface.mtu = 72;
    interface.transmit_errors = 12;
    EXPECT_EQ(summary(interface),
              "can0: can, up, 500 kbit/s (data 4000 kbit/s), sample point 87.5 %, MTU 72 (FD), "
              "queue 10, restart-ms 100, error-active, error counters 12 sending, 0 receiving");
}

TEST(CanInterfaceSummary, LeavesOutWhatAVirtualBusDoesNotHave) {
    EXPECT_EQ(summary(virtual_bus()), "vcan0: vcan, up, MTU 72 (FD), queue 0");
}

TEST(CanInterfaceQuery, SaysThatThereIsNoSuchInterface) {
    const auto answer = query_can_interface("no-such-can");
    ASSERT_FALSE(answer);
    EXPECT_EQ(answer.error().rfind("no-such-can: there is no such network interface; ", 0), 0U)
        << answer.error();
}

TEST(CanInterfaceQuery, SaysThatAnInterfaceIsNotCan) {
    const auto answer = query_can_interface("lo");
    ASSERT_FALSE(answer);
    EXPECT_EQ(answer.error().rfind("lo: this network interface is not a CAN interface; ", 0), 0U)
        << answer.error();
}

TEST(CanInterfaceQuery, RefusesNamesThatNoInterfaceCanHave) {
    EXPECT_FALSE(query_can_interface(""));
    EXPECT_FALSE(query_can_interface("sixteen-letters-"));
}

}  // namespace
}  // namespace tribus::can_interface_test
