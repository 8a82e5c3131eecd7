#include <linux/sock_diag.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "transports/links/can/can_socket.h"
#include "transports/links/can/interface_change.h"

/// The state of the interface of a CAN socket.
namespace tribus {

bool CanSocket::works() const {
    const CanBusState state = transmitter_.state();
    return state != CanBusState::down && state != CanBusState::bus_off &&
           state != CanBusState::stalled;
}

/// Takes what the kernel has told of the interface since the latest call. Returns whether that may
/// change anything. Costs one system call where it was nothing. The interface is not asked for: an
/// ioctl with a name may load a module, and a request to rtnetlink waits for other programs.
bool CanSocket::read_changes(Instant now) {
    constexpr int kMostMessages = 1024;
    bool changed = false;
    for (int message = 0; !lost_; ++message) {
        const ssize_t size = ::recv(changes_.get(), change_.data(), change_.size(), MSG_DONTWAIT);
        // Without what the kernel had no room for, the state is unknown: the interface is opened
        // again.
        lost_ = (size < 0 && errno == ENOBUFS) || message == kMostMessages;
        if (size < 0) {
            break;
        }
        const auto change = parse_interface_change(
            std::span<const std::byte>(change_).first(static_cast<std::size_t>(size)));
        if (change && change->index == interface_.index) {
            // The socket stays with its interface when that gets another name; then the bus that is
            // meant is elsewhere.
            lost_ = lost_ || change->gone || change->name != interface_.name;
            is_up_ = change->up;
            is_running_ = change->running;
            changed = true;
        }
    }
    if (changed && !lost_) {
        judge_line(now);
    }
    return changed || lost_;
}

void CanSocket::recheck(Instant now) {
    check_line(now);
    if (!interface_.echo || transmitter_.state() != CanBusState::stalled) {
        return;
    }
    // A confirmation for which the socket had no room will never come.
    const bool all_read = emptied_ && *emptied_ > transmitter_.in_flight_since();
    if (all_read && kernel_queues().drops != drops_when_handed_) {
        transmitter_.forget_flight();
    }
}

void CanSocket::check_line(Instant now) {
    if (!read_changes(now) && !lost_) {
        judge_line(now);
    }
}

/// Frames for an interface without carrier vanish although sending succeeds (docs/protocols/can.md,
/// "SocketCAN: transmit queue"). A controller has a carrier while it is up, except in bus-off.
void CanSocket::judge_line(Instant now) {
    checked_ = now;
    if (is_up_ && !up_since_) {
        up_since_ = now;
    }
    awaits_carrier_ = false;
    if (is_up_ && is_running_) {
        transmitter_.came_up(now);
        if (std::exchange(no_carrier_, false)) {
            transmitter_.restarted(now);
        }
    } else if (!is_up_ || interface_.kind != "can") {
        went_down();
    } else if (transmitter_.state() != CanBusState::bus_off &&
               now < later(*up_since_, kCarrierLag)) {
        awaits_carrier_ = true;
        transmitter_.came_up(now);
    } else {
        no_carrier_ = true;
        transmitter_.bus_off(now);
    }
}

void CanSocket::went_down() {
    up_since_.reset();
    awaits_carrier_ = false;
    no_carrier_ = false;
    transmitter_.went_down();
}

CanSocket::KernelQueues CanSocket::kernel_queues() const {
    std::array<std::uint32_t, SK_MEMINFO_VARS> info{};
    socklen_t size = sizeof info;
    if (::getsockopt(fd_.get(), SOL_SOCKET, SO_MEMINFO, info.data(), &size) != 0) {
        return {};
    }
    return {.sending = info[SK_MEMINFO_WMEM_ALLOC], .drops = info[SK_MEMINFO_DROPS]};
}

}  // namespace tribus
