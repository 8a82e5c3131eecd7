#include "transports/links/can/interface_change.h"

#include <arpa/inet.h>
#include <linux/filter.h>
#include <linux/netlink.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cstddef>

#include "transports/links/can/netlink_attributes.h"

namespace tribus {
namespace {

std::string_view text_of(std::span<const std::byte> bytes) {
    const auto end = std::find(bytes.begin(), bytes.end(), std::byte{0});
    return {reinterpret_cast<const char*>(bytes.data()),
            static_cast<std::size_t>(end - bytes.begin())};
}

}  // namespace

std::optional<InterfaceChange> parse_interface_change(std::span<const std::byte> message) {
    const auto head = take<nlmsghdr>(message);
    if (!head || (head->nlmsg_type != RTM_NEWLINK && head->nlmsg_type != RTM_DELLINK)) {
        return std::nullopt;
    }
    message = message.subspan(NLMSG_HDRLEN);
    const auto link = take<ifinfomsg>(message);
    // Bridges have messages of their own about an interface.
    if (!link || link->ifi_family != AF_UNSPEC) {
        return std::nullopt;
    }
    InterfaceChange change{.index = static_cast<std::uint32_t>(link->ifi_index),
                           .gone = head->nlmsg_type == RTM_DELLINK,
                           .up = (link->ifi_flags & IFF_UP) != 0,
                           .running = (link->ifi_flags & IFF_RUNNING) != 0};
    for_attributes(message.subspan(NLMSG_ALIGN(sizeof(ifinfomsg))),
                   [&](unsigned type, std::span<const std::byte> payload) {
                       if (type == IFLA_IFNAME) {
                           change.name = text_of(payload);
                       }
                   });
    return change;
}

UniqueFd watch_interfaces() {
    UniqueFd fd(::socket(AF_NETLINK, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, NETLINK_ROUTE));
    sockaddr_nl address{};
    address.nl_family = AF_NETLINK;
    address.nl_groups = RTMGRP_LINK;
    const auto* generic = static_cast<const sockaddr*>(static_cast<const void*>(&address));
    if (fd.valid() && ::bind(fd.get(), generic, sizeof address) != 0) {
        fd = UniqueFd();
    }
    return fd;
}

void watch_only(const UniqueFd& changes, std::uint32_t index) {
    constexpr std::uint32_t kPlaceOfIndex = NLMSG_HDRLEN + offsetof(ifinfomsg, ifi_index);
    // The filter reads the number as one in the network's order, but it is in the processor's.
    std::array<sock_filter, 4> program{{BPF_STMT(BPF_LD | BPF_W | BPF_ABS, kPlaceOfIndex),
                                        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, htonl(index), 0, 1),
                                        BPF_STMT(BPF_RET | BPF_K, UINT32_MAX),
                                        BPF_STMT(BPF_RET | BPF_K, 0)}};
    const sock_fprog filter{.len = program.size(), .filter = program.data()};
    ::setsockopt(changes.get(), SOL_SOCKET, SO_ATTACH_FILTER, &filter, sizeof filter);
}

}  // namespace tribus
