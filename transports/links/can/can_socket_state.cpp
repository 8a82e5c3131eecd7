#include <linux/netlink.h>
#include <linux/sock_diag.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <utility>

#include "transports/links/can/can_socket.h"

/// The state of the interface of a CAN socket.
namespace tribus {

bool CanSocket::works() const {
    const CanBusState state = transmitter_.state();
    return state != CanBusState::down && state != CanBusState::bus_off &&
           state != CanBusState::stalled;
}

/// The kernel tells that some network interface has changed; this one is then looked at, and true
/// returned. Costs one system call where nothing has.
bool CanSocket::read_changes(Instant now) {
    constexpr int kMostMessages = 64;
    std::array<std::byte, sizeof(nlmsghdr)> beginning{};
    bool changed = false;
    for (int message = 0; message < kMostMessages; ++message) {
        const ssize_t size =
            ::recv(changes_.get(), beginning.data(), beginning.size(), MSG_DONTWAIT);
        // ENOBUFS: the kernel had no room for all messages.
        if (size < 0 && errno != ENOBUFS) {
            break;
        }
        changed = true;
    }
    if (changed) {
        check_line(now);
    }
    return changed;
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

/// Frames for an interface without carrier vanish although sending succeeds (docs/protocols/can.md,
/// "SocketCAN: transmit queue"). A controller has a carrier while it is up, except in bus-off. The
/// socket stays with its interface when that gets another name; then the bus that is meant is
/// elsewhere.
void CanSocket::check_line(Instant now) {
    checked_ = now;
    ifreq line{};
    interface_.name.copy(std::begin(line.ifr_name), IFNAMSIZ - 1);
    if (::ioctl(fd_.get(), SIOCGIFINDEX, &line) != 0) {
        lost_ = lost_ || interface_is_gone(errno);
        return;
    }
    if (static_cast<std::uint32_t>(line.ifr_ifindex) != interface_.index) {
        lost_ = true;
        return;
    }
    if (::ioctl(fd_.get(), SIOCGIFFLAGS, &line) != 0) {
        lost_ = lost_ || interface_is_gone(errno);
        return;
    }
    const auto flags = static_cast<unsigned>(line.ifr_flags);
    const bool up = (flags & IFF_UP) != 0;
    const bool runs = up && (flags & IFF_RUNNING) != 0;
    if (up && !up_since_) {
        up_since_ = now;
    }
    awaits_carrier_ = false;
    if (runs) {
        transmitter_.came_up(now);
        if (std::exchange(no_carrier_, false)) {
            transmitter_.restarted(now);
        }
    } else if (!up || interface_.kind != "can") {
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
