#include "transports/links/can/can_interface.h"

#include <linux/can.h>
#include <linux/can/netlink.h>
#include <linux/if.h>
#include <linux/if_arp.h>
#include <linux/if_link.h>
#include <linux/rtnetlink.h>

#include <algorithm>

#include "transports/links/can/netlink_attributes.h"

namespace tribus {

namespace {

std::string text(std::span<const std::byte> bytes) {
    std::string result;
    for (const std::byte byte : bytes) {
        if (byte == std::byte{0}) {
            break;
        }
        result.push_back(static_cast<char>(byte));
    }
    return result;
}

std::optional<CanControllerState> controller_state(std::uint32_t state) {
    if (state >= CAN_STATE_MAX) {
        return std::nullopt;
    }
    // CanControllerState has the kernel's order.
    static_assert(static_cast<int>(CanControllerState::bus_off) == CAN_STATE_BUS_OFF);
    static_assert(static_cast<int>(CanControllerState::sleeping) == CAN_STATE_SLEEPING);
    return static_cast<CanControllerState>(state);
}

void take_modes(std::uint32_t flags, CanInterface& interface) {
    interface.loopback = (flags & CAN_CTRLMODE_LOOPBACK) != 0;
    interface.listen_only = (flags & CAN_CTRLMODE_LISTENONLY) != 0;
    interface.one_shot = (flags & CAN_CTRLMODE_ONE_SHOT) != 0;
    interface.fd = (flags & CAN_CTRLMODE_FD) != 0;
    interface.bus_error_reporting = (flags & CAN_CTRLMODE_BERR_REPORTING) != 0;
}

void take_controller_attribute(unsigned type, std::span<const std::byte> bytes,
                               CanInterface& interface) {
    if (type == IFLA_CAN_BITTIMING || type == IFLA_CAN_DATA_BITTIMING) {
        const auto timing = take<can_bittiming>(bytes);
        if (!timing || timing->bitrate == 0) {
            return;
        }
        if (type == IFLA_CAN_DATA_BITTIMING) {
            interface.data_bit_rate = timing->bitrate;
        } else {
            interface.bit_rate = timing->bitrate;
            interface.sample_point_permille = timing->sample_point;
        }
    } else if (type == IFLA_CAN_STATE) {
        if (const auto state = take<std::uint32_t>(bytes)) {
            interface.state = controller_state(*state);
        }
    } else if (type == IFLA_CAN_CTRLMODE) {
        if (const auto modes = take<can_ctrlmode>(bytes)) {
            take_modes(modes->flags, interface);
        }
    } else if (type == IFLA_CAN_RESTART_MS) {
        interface.restart_ms = take<std::uint32_t>(bytes);
    } else if (type == IFLA_CAN_BERR_COUNTER) {
        if (const auto counters = take<can_berr_counter>(bytes)) {
            interface.transmit_errors = counters->txerr;
            interface.receive_errors = counters->rxerr;
        }
    }
}

void take_link_info(std::span<const std::byte> bytes, CanInterface& interface) {
    std::span<const std::byte> data;
    for_attributes(bytes, [&](unsigned type, std::span<const std::byte> payload) {
        if (type == IFLA_INFO_KIND) {
            interface.kind = text(payload);
        } else if (type == IFLA_INFO_DATA) {
            data = payload;
        }
    });
    // For vxcan, the same attribute numbers have other meanings.
    if (interface.kind == "can") {
        for_attributes(data, [&](unsigned type, std::span<const std::byte> payload) {
            take_controller_attribute(type, payload, interface);
        });
    }
}

std::string bit_rate_text(std::uint32_t bit_rate) {
    if (bit_rate % 1000 == 0) {
        return std::to_string(bit_rate / 1000) + " kbit/s";
    }
    return std::to_string(bit_rate) + " bit/s";
}

const char* state_text(CanControllerState state) {
    switch (state) {
        case CanControllerState::active:
            return "error-active";
        case CanControllerState::warning:
            return "error-warning";
        case CanControllerState::passive:
            return "error-passive";
        case CanControllerState::bus_off:
            return "bus-off";
        case CanControllerState::stopped:
            return "stopped";
        case CanControllerState::sleeping:
            return "sleeping";
    }
    return "unknown";
}

std::string set_link(const CanInterface& interface, const std::string& what) {
    return "`ip link set " + interface.name + " " + what + "`";
}

/// Commands for a controller setting, which the kernel refuses while the interface is up.
std::string set_controller(const CanInterface& interface, const std::string& what) {
    return "`ip link set " + interface.name + " down`, " + set_link(interface, "type can " + what) +
           ", " + set_link(interface, "up");
}

void advise_on_sending(const CanInterface& interface, std::vector<std::string>& sentences) {
    if (interface.listen_only) {
        sentences.push_back("it is in listen-only mode and sends nothing: " +
                            set_controller(interface, "listen-only off"));
    }
    if (interface.loopback) {
        sentences.push_back("it is in loopback mode: its frames do not reach the bus: " +
                            set_controller(interface, "loopback off"));
    }
    if (interface.one_shot) {
        sentences.push_back(
            "it is in one-shot mode: a frame that loses the arbitration is not repeated: " +
            set_controller(interface, "one-shot off"));
    }
    if (interface.queue_length > kMostUsefulQueue) {
        sentences.push_back("its queue holds " + std::to_string(interface.queue_length) +
                            " frames: while no node acknowledges, frames of other programs "
                            "collect there and are old when they are sent: " +
                            set_link(interface, "txqueuelen 16"));
    }
}

}  // namespace

bool CanInterface::takes_fd() const {
    return mtu >= CANFD_MTU;
}

std::optional<CanInterface> parse_link_message(std::span<const std::byte> message) {
    const auto head = take<nlmsghdr>(message);
    if (!head || head->nlmsg_type != RTM_NEWLINK || head->nlmsg_len > message.size()) {
        return std::nullopt;
    }
    message = message.first(head->nlmsg_len);
    message = message.subspan(std::min<std::size_t>(message.size(), NLMSG_HDRLEN));
    const auto link = take<ifinfomsg>(message);
    if (!link) {
        return std::nullopt;
    }
    CanInterface interface;
    interface.index = static_cast<std::uint32_t>(link->ifi_index);
    interface.is_can = link->ifi_type == ARPHRD_CAN;
    interface.up = (link->ifi_flags & IFF_UP) != 0;
    interface.lower_up = (link->ifi_flags & IFF_LOWER_UP) != 0;
    interface.running = (link->ifi_flags & IFF_RUNNING) != 0;
    interface.echo = (link->ifi_flags & IFF_ECHO) != 0;
    for_attributes(message.subspan(NLMSG_ALIGN(sizeof(ifinfomsg))),
                   [&](unsigned type, std::span<const std::byte> payload) {
                       if (type == IFLA_IFNAME) {
                           interface.name = text(payload);
                       } else if (type == IFLA_MTU) {
                           interface.mtu = take<std::uint32_t>(payload).value_or(0);
                       } else if (type == IFLA_TXQLEN) {
                           interface.queue_length = take<std::uint32_t>(payload).value_or(0);
                       } else if (type == IFLA_LINKINFO) {
                           take_link_info(payload, interface);
                       }
                   });
    return interface;
}

std::optional<std::string> fd_problem(const CanInterface& interface) {
    if (interface.takes_fd()) {
        return std::nullopt;
    }
    if (interface.kind == "can") {
        const std::string bit_rate = std::to_string(interface.bit_rate.value_or(1000000));
        return "FD frames are configured, but its controller is not in FD mode: " +
               set_controller(interface, "bitrate " + bit_rate + " dbitrate 4000000 fd on") +
               ", with the bit rates of the bus";
    }
    return "FD frames are configured, but its MTU is " + std::to_string(interface.mtu) +
           ": `ip link set " + interface.name + " down`, " + set_link(interface, "mtu 72") + ", " +
           set_link(interface, "up");
}

std::vector<std::string> advice(const CanInterface& interface, bool sends, bool fd_wanted) {
    std::vector<std::string> sentences;
    if (!interface.up) {
        const bool without_rate = interface.kind == "can" && !interface.bit_rate;
        sentences.push_back(
            "it is down: " +
            set_link(interface, without_rate ? "up type can bitrate 1000000" : "up") +
            (without_rate ? " with the bit rate of the bus" : ""));
    } else if (!interface.lower_up && interface.state != CanControllerState::bus_off) {
        sentences.push_back("it has no carrier: its other end is not connected, or down");
    }
    if (interface.state == CanControllerState::bus_off) {
        sentences.push_back("its controller is in bus-off and sends nothing: " +
                            set_link(interface, "type can restart") +
                            ", then check bit rate, wiring and termination");
    }
    if (interface.restart_ms == 0U) {
        sentences.push_back("after a bus-off it sends nothing until it is restarted by hand: " +
                            set_controller(interface, "restart-ms 100"));
    }
    if (sends) {
        advise_on_sending(interface, sentences);
    }
    if (const auto problem = fd_problem(interface); problem && fd_wanted) {
        sentences.push_back(*problem);
    }
    return sentences;
}

std::string summary(const CanInterface& interface) {
    std::string line = interface.name + ": " +
                       (interface.kind.empty() ? std::string("CAN interface") : interface.kind) +
                       (interface.up ? ", up" : ", down");
    if (interface.up && !interface.lower_up) {
        line += " without carrier";
    }
    if (interface.bit_rate) {
        line += ", " + bit_rate_text(*interface.bit_rate);
        if (interface.data_bit_rate) {
            line += " (data " + bit_rate_text(*interface.data_bit_rate) + ")";
        }
    }
    if (interface.sample_point_permille) {
        line += ", sample point " + std::to_string(*interface.sample_point_permille / 10) + "." +
                std::to_string(*interface.sample_point_permille % 10) + " %";
    }
    line += ", MTU " + std::to_string(interface.mtu) + (interface.takes_fd() ? " (FD)" : "");
    line += ", queue " + std::to_string(interface.queue_length);
    if (interface.restart_ms) {
        line += ", restart-ms " + std::to_string(*interface.restart_ms);
    }
    if (interface.state) {
        line += std::string(", ") + state_text(*interface.state);
    }
    if (interface.transmit_errors || interface.receive_errors) {
        line += ", error counters " + std::to_string(interface.transmit_errors.value_or(0)) +
                " sending, " + std::to_string(interface.receive_errors.value_or(0)) + " receiving";
    }
    return line;
}

}  // namespace tribus
