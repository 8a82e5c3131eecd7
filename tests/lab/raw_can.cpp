#include "tests/lab/raw_can.h"

#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <ctime>

#include <gtest/gtest.h>

namespace tribus::test {
namespace {

template <class Value>
void set_option(int fd, int level, int option, const Value& value) {
    EXPECT_EQ(::setsockopt(fd, level, option, &value, sizeof(value)), 0)
        << "option " << option << ": " << std::strerror(errno);
}

int send_bytes(int fd, const void* bytes, std::size_t size) {
    const ssize_t taken = ::send(fd, bytes, size, MSG_DONTWAIT);
    if (taken < 0) {
        return errno;
    }
    return static_cast<std::size_t>(taken) == size ? 0 : EMSGSIZE;
}

CanSight sight_of(const canfd_frame& raw, std::size_t size) {
    CanSight sight;
    sight.error = (raw.can_id & CAN_ERR_FLAG) != 0;
    sight.frame.extended = (raw.can_id & CAN_EFF_FLAG) != 0;
    sight.frame.remote = (raw.can_id & CAN_RTR_FLAG) != 0;
    sight.frame.fd = size == CANFD_MTU;
    sight.frame.bit_rate_switch = sight.frame.fd && (raw.flags & CANFD_BRS) != 0;
    sight.frame.error_state_indicator = sight.frame.fd && (raw.flags & CANFD_ESI) != 0;
    sight.frame.id =
        raw.can_id & (sight.error || sight.frame.extended ? CAN_EFF_MASK : CAN_SFF_MASK);
    sight.frame.length = raw.len;
    std::copy_n(raw.data, raw.len, sight.frame.data.begin());
    return sight;
}

std::chrono::nanoseconds kernel_time_of(msghdr& message) {
    for (cmsghdr* part = CMSG_FIRSTHDR(&message); part != nullptr;
         part = CMSG_NXTHDR(&message, part)) {
        if (part->cmsg_level == SOL_SOCKET && part->cmsg_type == SCM_TIMESTAMPNS) {
            timespec time{};
            std::memcpy(&time, CMSG_DATA(part), sizeof(time));
            return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
        }
    }
    return {};
}

}  // namespace

CanFrame make_frame(std::uint32_t id, const std::vector<std::uint8_t>& data, bool fd) {
    CanFrame frame;
    frame.id = id;
    frame.extended = id > kMostStandardId;
    frame.fd = fd;
    frame.length = static_cast<std::uint8_t>(data.size());
    std::copy(data.begin(), data.end(), frame.data.begin());
    return frame;
}

RawCan::RawCan(const std::string& interface, const RawCanSettings& settings)
    : fd_(::socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, CAN_RAW)) {
    EXPECT_TRUE(fd_.valid()) << "no CAN socket: " << std::strerror(errno);
    set_option(fd_.get(), SOL_CAN_RAW, CAN_RAW_FD_FRAMES, settings.fd ? 1 : 0);
    set_option(fd_.get(), SOL_CAN_RAW, CAN_RAW_RECV_OWN_MSGS, settings.own_frames ? 1 : 0);
    set_option(fd_.get(), SOL_CAN_RAW, CAN_RAW_ERR_FILTER, can_err_mask_t{settings.errors});
    set_option(fd_.get(), SOL_SOCKET, SO_TIMESTAMPNS, 1);
    if (!settings.data_frames) {
        EXPECT_EQ(::setsockopt(fd_.get(), SOL_CAN_RAW, CAN_RAW_FILTER, nullptr, 0), 0);
    }
    sockaddr_can address{};
    address.can_family = AF_CAN;
    address.can_ifindex = static_cast<int>(::if_nametoindex(interface.c_str()));
    EXPECT_NE(address.can_ifindex, 0) << "no interface " << interface;
    // The type that the socket interface requires.
    const auto* any = reinterpret_cast<const sockaddr*>(&address);
    EXPECT_EQ(::bind(fd_.get(), any, sizeof(address)), 0) << interface << std::strerror(errno);
}

int RawCan::send(const CanFrame& frame) {
    canfd_frame raw{};
    raw.can_id =
        frame.id | (frame.extended ? CAN_EFF_FLAG : 0U) | (frame.remote ? CAN_RTR_FLAG : 0U);
    raw.len = frame.length;
    raw.flags = static_cast<std::uint8_t>((frame.bit_rate_switch ? CANFD_BRS : 0) |
                                          (frame.error_state_indicator ? CANFD_ESI : 0));
    std::copy_n(frame.data.begin(), frame.length, raw.data);
    if (!frame.fd) {
        raw.flags = 0;
    }
    return send_bytes(fd_.get(), &raw, frame.fd ? CANFD_MTU : CAN_MTU);
}

int RawCan::send_error(std::uint32_t classes, const std::vector<std::uint8_t>& data) {
    ::can_frame raw{};
    raw.can_id = classes | CAN_ERR_FLAG;
    raw.len = CAN_ERR_DLC;
    std::copy_n(data.begin(), std::min<std::size_t>(data.size(), CAN_ERR_DLC), raw.data);
    return send_bytes(fd_.get(), &raw, CAN_MTU);
}

std::optional<CanSight> RawCan::receive(std::chrono::milliseconds wait) {
    pollfd ready{.fd = fd_.get(), .events = POLLIN, .revents = 0};
    if (::poll(&ready, 1, static_cast<int>(wait.count())) <= 0) {
        return std::nullopt;
    }
    canfd_frame raw{};
    iovec part{.iov_base = &raw, .iov_len = sizeof(raw)};
    alignas(cmsghdr) std::array<char, 128> extra{};
    msghdr message{};
    message.msg_iov = &part;
    message.msg_iovlen = 1;
    message.msg_control = extra.data();
    message.msg_controllen = extra.size();
    const ssize_t taken = ::recvmsg(fd_.get(), &message, MSG_DONTWAIT);
    if (taken < 0) {
        read_error_ = errno == EAGAIN ? read_error_ : errno;
        return std::nullopt;
    }
    CanSight sight = sight_of(raw, static_cast<std::size_t>(taken));
    sight.seen = std::chrono::steady_clock::now();
    sight.own = (message.msg_flags & MSG_CONFIRM) != 0;
    sight.local = (message.msg_flags & MSG_DONTROUTE) != 0;
    sight.kernel_time = kernel_time_of(message);
    return sight;
}

std::vector<CanSight> RawCan::receive_all() {
    std::vector<CanSight> all;
    while (auto sight = receive(std::chrono::milliseconds(0))) {
        all.push_back(*sight);
    }
    return all;
}

std::vector<CanSight> RawCan::receive_all(std::size_t expected) {
    std::vector<CanSight> all;
    while (all.size() < expected) {
        const auto sight = receive();
        if (!sight) {
            return all;
        }
        all.push_back(*sight);
    }
    const auto more = receive_all();
    all.insert(all.end(), more.begin(), more.end());
    return all;
}

}  // namespace tribus::test
