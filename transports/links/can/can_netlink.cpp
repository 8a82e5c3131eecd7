#include "transports/links/can/can_netlink.h"

#include <linux/can/netlink.h>
#include <linux/if.h>
#include <linux/if_link.h>
#include <linux/rtnetlink.h>
#include <sys/socket.h>
#include <sys/time.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <string_view>
#include <utility>

namespace tribus {

namespace {

/// The kernel sends the answer to a dump in parts of at most 32 kB.
constexpr std::size_t kAnswerBytes = 32768;
/// Limit of the parts of one answer: far more interfaces than any machine has.
constexpr int kMostParts = 1000;
/// The kernel answers at once, or after another program has changed an interface.
constexpr int kMostSecondsToAnswer = 5;

/// One rtnetlink request, built attribute by attribute.
class Request {
  public:
    Request(std::uint16_t type, std::uint16_t flags) {
        nlmsghdr head{};
        head.nlmsg_type = type;
        head.nlmsg_flags = static_cast<std::uint16_t>(NLM_F_REQUEST | flags);
        append(&head, sizeof head);
        const ifinfomsg link{};
        append(&link, sizeof link);
    }

    void add(std::uint16_t type, const void* payload, std::size_t size) {
        const std::size_t start = open(type);
        append(payload, size);
        close(start);
    }
    void add(std::uint16_t type, const std::string& text) {
        add(type, text.c_str(), text.size() + 1);
    }

    /// Begins an attribute that contains those that are added until `close`.
    std::size_t open(std::uint16_t type) {
        const std::size_t start = bytes_.size();
        rtattr head{};
        head.rta_type = type;
        append(&head, sizeof head);
        return start;
    }
    void close(std::size_t start) {
        const auto length = static_cast<std::uint16_t>(bytes_.size() - start);
        static_assert(offsetof(rtattr, rta_len) == 0);
        std::memcpy(bytes_.data() + start, &length, sizeof length);
        bytes_.resize((bytes_.size() + 3) / 4 * 4);
    }

    NetlinkRequest finished() {
        const auto length = static_cast<std::uint32_t>(bytes_.size());
        static_assert(offsetof(nlmsghdr, nlmsg_len) == 0);
        std::memcpy(bytes_.data(), &length, sizeof length);
        return bytes_;
    }

  private:
    void append(const void* data, std::size_t size) {
        const auto* first = static_cast<const std::byte*>(data);
        bytes_.insert(bytes_.end(), first, first + size);
    }

    std::vector<std::byte> bytes_;
};

}  // namespace

NetlinkRequest request_of_interface(const std::string& name) {
    Request request(RTM_GETLINK, 0);
    request.add(IFLA_IFNAME, name);
    return request.finished();
}

NetlinkRequest request_of_all_interfaces() {
    return Request(RTM_GETLINK, NLM_F_DUMP).finished();
}

NetlinkRequest request_of_restart(const std::string& name) {
    Request request(RTM_NEWLINK, NLM_F_ACK);
    request.add(IFLA_IFNAME, name);
    const std::size_t link_info = request.open(IFLA_LINKINFO);
    request.add(IFLA_INFO_KIND, "can", std::string_view("can").size());
    const std::size_t data = request.open(IFLA_INFO_DATA);
    constexpr std::uint32_t kRestart = 1;
    request.add(IFLA_CAN_RESTART, &kRestart, sizeof kRestart);
    request.close(data);
    request.close(link_info);
    return request.finished();
}

bool is_name_of_interface(const std::string& name) {
    return !name.empty() && name.size() < IFNAMSIZ;
}

tl::expected<bool, int> take_messages(std::span<const std::byte> datagram,
                                      std::vector<CanInterface>& found) {
    bool more = false;
    while (datagram.size() >= sizeof(nlmsghdr)) {
        nlmsghdr head{};
        std::memcpy(&head, datagram.data(), sizeof head);
        if (head.nlmsg_len < sizeof head || head.nlmsg_len > datagram.size()) {
            return tl::unexpected(EPROTO);
        }
        const auto message = datagram.first(head.nlmsg_len);
        if (head.nlmsg_type == NLMSG_DONE) {
            return false;
        }
        if (head.nlmsg_type == NLMSG_ERROR) {
            int error = -EPROTO;
            if (message.size() >= NLMSG_HDRLEN + sizeof error) {
                std::memcpy(&error, message.data() + NLMSG_HDRLEN, sizeof error);
            }
            return error == 0 ? tl::expected<bool, int>(false) : tl::unexpected(-error);
        }
        if (auto interface = parse_link_message(message)) {
            found.push_back(std::move(*interface));
        }
        more = more || (head.nlmsg_flags & NLM_F_MULTI) != 0;
        datagram =
            datagram.subspan(std::min<std::size_t>(datagram.size(), NLMSG_ALIGN(head.nlmsg_len)));
    }
    return more;
}

UniqueFd open_netlink() {
    UniqueFd fd(::socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE));
    if (fd.valid()) {
        const timeval limit{.tv_sec = kMostSecondsToAnswer, .tv_usec = 0};
        ::setsockopt(fd.get(), SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
    }
    return fd;
}

tl::expected<std::vector<CanInterface>, int> ask_by(int socket, const NetlinkRequest& request) {
    if (::send(socket, request.data(), request.size(), 0) == -1) {
        return tl::unexpected(errno);
    }
    std::vector<CanInterface> found;
    std::vector<std::byte> answer(kAnswerBytes);
    for (int part = 0; part < kMostParts; ++part) {
        const ssize_t size = ::recv(socket, answer.data(), answer.size(), 0);
        if (size == -1 && errno == EINTR) {
            continue;
        }
        if (size == -1) {
            return tl::unexpected(errno);
        }
        const auto more = take_messages(
            std::span<const std::byte>(answer).first(static_cast<std::size_t>(size)), found);
        if (!more) {
            return tl::unexpected(more.error());
        }
        if (!*more) {
            return found;
        }
    }
    return tl::unexpected(EPROTO);
}

std::string existing_can_interfaces(std::span<const CanInterface> all) {
    std::string names;
    for (const CanInterface& interface : all) {
        if (interface.is_can) {
            names += (names.empty() ? "" : ", ") + interface.name;
        }
    }
    if (names.empty()) {
        return "there is no CAN interface: a controller appears when its driver is loaded "
               "(on small boards an overlay enables it); `modprobe vcan; ip link add vcan0 type "
               "vcan; ip link set vcan0 up` makes a virtual "
               "one";
    }
    return "the CAN interfaces are: " + names;
}

std::string asking_problem(int error) {
    if (error == EAFNOSUPPORT || error == EACCES || error == EPERM) {
        return std::string(
                   "not permitted to read network interfaces from the kernel (AF_NETLINK; "
                   "a service needs it in RestrictAddressFamilies): ") +
               std::strerror(error);
    }
    return std::string("cannot read it from the kernel: ") + std::strerror(error);
}

std::string restart_problem(const std::string& name, int error) {
    switch (error) {
        case EPERM:
            return name +
                   ": not permitted to restart the controller: give the program CAP_NET_ADMIN, or "
                   "set restart-ms";
        case EINVAL:
        case EBUSY:
            return name + ": it cannot be restarted now: it is down, or not in bus-off";
        case EOPNOTSUPP:
            return name + ": its driver has no restart: `ip link set " + name +
                   " down`, `ip link set " + name + " up`";
        default:
            return name + ": cannot restart the controller: " + std::strerror(error);
    }
}

}  // namespace tribus
