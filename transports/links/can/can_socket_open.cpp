#include "transports/links/can/can_socket.h"

#include <linux/can/raw.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "transports/links/can/can_wire.h"
#include "transports/links/can/interface_change.h"

namespace tribus {

namespace {

/// Highest priority without CAP_NET_ADMIN; the first band of the usual queues.
constexpr int kPriority = 6;
/// The kernel raises this to its minimum, about 4 kB: some twelve frames. At most one snapshot of
/// ours is queued; the rest of a longer one follows when the queue is empty
/// (docs/protocols/can.md, "SocketCAN: transmit queue").
constexpr int kSendBufferBytes = 1;

std::string socket_problem(int error) {
    switch (error) {
        case EAFNOSUPPORT:
        case EPROTONOSUPPORT:
            return "this kernel has no raw CAN sockets: `modprobe can_raw`; if that fails, the "
                   "kernel was built without CAN, and a service needs AF_CAN in "
                   "RestrictAddressFamilies";
        case EPERM:
        case EACCES:
            return "not permitted to open a CAN socket; does a sandbox forbid AF_CAN?";
        default:
            return std::string("cannot open a CAN socket: ") + std::strerror(error);
    }
}

template <typename T>
bool set(int fd, int level, int option, const T& value) {
    return ::setsockopt(fd, level, option, &value, sizeof value) == 0;
}

/// Returns false only for options that are necessary.
bool set_options(int fd, const std::vector<can_filter>& filters, bool fd_frames, bool echo) {
    constexpr int kOn = 1;
    // Without echo, own frames return at once and tell nothing.
    const int own_frames = echo ? 1 : 0;
    // Above the system's limit if permitted, else up to that limit.
    if (!set(fd, SOL_SOCKET, SO_RCVBUFFORCE, CanSocket::kReceiveBufferBytes)) {
        set(fd, SOL_SOCKET, SO_RCVBUF, CanSocket::kReceiveBufferBytes);
    }
    set(fd, SOL_SOCKET, SO_SNDBUF, kSendBufferBytes);
    set(fd, SOL_SOCKET, SO_PRIORITY, kPriority);
    set(fd, SOL_SOCKET, SO_RXQ_OVFL, kOn);
    set(fd, SOL_SOCKET, SO_TIMESTAMPNS, kOn);
    // FD frames of other nodes are read even if we send none.
    const bool fd_set = set(fd, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, kOn);
    return (fd_set || !fd_frames) && set(fd, SOL_CAN_RAW, CAN_RAW_LOOPBACK, kOn) &&
           set(fd, SOL_CAN_RAW, CAN_RAW_RECV_OWN_MSGS, own_frames) &&
           set(fd, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, kWantedErrors) &&
           ::setsockopt(fd, SOL_CAN_RAW, CAN_RAW_FILTER, filters.data(),
                        static_cast<socklen_t>(filters.size() * sizeof(can_filter))) == 0;
}

std::string bind_problem(int error) {
    if (error == ENODEV || error == ENXIO) {
        return "it was just removed; is the adapter plugged in?";
    }
    return std::string("cannot use it: ") + std::strerror(error);
}

}  // namespace

tl::expected<std::unique_ptr<CanSocket>, std::string> CanSocket::open(const std::string& interface,
                                                                      const LinkUse& settings) {
    const auto failed = [&interface](const std::string& why) {
        return tl::unexpected(interface + ": " + why);
    };
    UniqueFd fd(::socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW));
    if (!fd.valid()) {
        return failed(socket_problem(errno));
    }
    // Before the interface is read, so that no change of it is missed.
    UniqueFd changes = watch_interfaces();
    if (!changes.valid()) {
        return failed(std::string("the kernel does not tell of changes of network interfaces "
                                  "(AF_NETLINK; a service needs it in "
                                  "RestrictAddressFamilies): ") +
                      std::strerror(errno));
    }
    auto found = query_can_interface(interface);
    if (!found) {
        return tl::unexpected(found.error());
    }
    watch_only(changes, found->index);
    if (const auto problem = fd_problem(*found); problem && settings.fd) {
        return failed(*problem);
    }
    std::vector<CanIdMatch> ids = settings.wanted;
    ids.insert(ids.end(), settings.sent.begin(), settings.sent.end());
    const auto filters = kernel_filters(ids);
    if (filters.size() > kMostCanFilters) {
        return failed("its inputs and outputs name " + std::to_string(filters.size()) +
                      " different ids; the kernel filters at most " +
                      std::to_string(kMostCanFilters) + " for one program: use fewer messages");
    }
    // Before the socket is bound, so that every frame passes the filters.
    if (!set_options(fd.get(), filters, settings.fd, found->echo)) {
        return failed(std::string("the kernel refuses the socket's settings: ") +
                      std::strerror(errno));
    }
    sockaddr_can address{};
    address.can_family = AF_CAN;
    address.can_ifindex = static_cast<int>(found->index);
    // bind accepts only this kind of address.
    const auto* generic = static_cast<const sockaddr*>(static_cast<const void*>(&address));
    if (::bind(fd.get(), generic, sizeof address) != 0) {
        return failed(bind_problem(errno));
    }
    return std::unique_ptr<CanSocket>(
        new CanSocket(std::move(fd), std::move(changes), std::move(*found)));
}

}  // namespace tribus
