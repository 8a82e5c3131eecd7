#include <linux/can.h>
#include <sys/socket.h>
#include <time.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string_view>

#include "core/can_frame.h"
#include "transports/links/can/can_socket.h"
#include "transports/links/can/can_wire.h"

/// count_link WORKLOAD UNITS
///
/// Passes UNITS snapshots of five frames through the link of a CAN interface, under virtual time,
/// and prints the system calls. The functions of the C library that it calls are replaced by a bus
/// without faults, whose own instructions are few. As count_codecs: the difference between two runs
/// with other UNITS is only the work. WORKLOAD: `out_with_echo` and `out_without_echo` send the
/// snapshots, `in` reads them.
namespace tribus {
namespace {

constexpr std::size_t kFrames = 5;
constexpr int kIndex = 1;  ///< of the interface

/// Holds the frames that the socket reads next.
struct Kernel {
    std::array<canfd_frame, 64> waiting{};
    std::size_t count = 0;
    int flags = 0;  ///< of every waiting frame
    bool echo = false;
    std::uint64_t calls = 0;

    void put(const canfd_frame& frame) { waiting[count++] = frame; }
};
Kernel kernel;

int taken_by_kernel(mmsghdr* messages, unsigned count) {
    ++kernel.calls;
    for (unsigned i = 0; kernel.echo && i < count; ++i) {
        kernel.put(*static_cast<const canfd_frame*>(messages[i].msg_hdr.msg_iov->iov_base));
    }
    return static_cast<int>(count);
}

/// The kernel's stamp of a frame that came at `since_1970`.
void add_stamp(msghdr& header, timespec since_1970) {
    cmsghdr* item = CMSG_FIRSTHDR(&header);
    item->cmsg_level = SOL_SOCKET;
    item->cmsg_type = SCM_TIMESTAMPNS;
    item->cmsg_len = CMSG_LEN(sizeof since_1970);
    std::memcpy(CMSG_DATA(item), &since_1970, sizeof since_1970);
    header.msg_controllen = CMSG_SPACE(sizeof since_1970);
}

timespec stamp{};

int given_by_kernel(mmsghdr* messages, unsigned count) {
    ++kernel.calls;
    const auto given = std::min<std::size_t>(count, kernel.count);
    for (std::size_t i = 0; i < given; ++i) {
        std::memcpy(messages[i].msg_hdr.msg_iov->iov_base, &kernel.waiting[i], CAN_MTU);
        messages[i].msg_len = CAN_MTU;
        messages[i].msg_hdr.msg_flags = kernel.flags;
        add_stamp(messages[i].msg_hdr, stamp);
    }
    kernel.count = 0;
    errno = EAGAIN;
    return given > 0 ? static_cast<int>(given) : -1;
}

/// Does for the link what the loop of the program does.
class Driver {
  public:
    explicit Driver(bool echo) {
        CanInterface interface;
        interface.name = "can0";
        interface.kind = "can";
        interface.index = kIndex;
        interface.up = true;
        interface.lower_up = true;
        interface.running = true;
        interface.echo = echo;
        kernel.echo = echo;
        link_ = std::make_unique<CanSocket>(UniqueFd(), UniqueFd(), interface);
        for (std::size_t i = 0; i < kFrames; ++i) {
            snapshot_[i].id = 0x300 + static_cast<std::uint32_t>(i);
            snapshot_[i].length = kMostClassicBytes;
        }
    }

    void send() {
        kernel.flags = MSG_CONFIRM;
        begin_unit();
        link_->write(0, snapshot_, now_);
        link_->poll(now_);
        read_all();
    }
    void receive() {
        kernel.flags = 0;
        begin_unit();
        for (const CanFrame& frame : snapshot_) {
            canfd_frame wire{};
            to_wire(frame, wire);
            kernel.put(wire);
        }
        read_all();
    }
    bool works() const {
        const CanCounts counts = link_->status().counts;
        return counts.sent == counts.confirmed && counts.abandoned == 0 &&
               counts.sent + counts.received == units_ * kFrames;
    }

  private:
    void begin_unit() {
        ++units_;
        now_ += std::chrono::milliseconds(10);
        for (CanFrame& frame : snapshot_) {
            std::memcpy(frame.data.data(), &units_, sizeof units_);
        }
        const auto since = now_.time_since_epoch();
        stamp = {.tv_sec = since / std::chrono::seconds(1),
                 .tv_nsec = since % std::chrono::seconds(1) / std::chrono::nanoseconds(1)};
    }
    void read_all() {
        do {
            ++kernel.calls;  // the loop waits
            if (kernel.count > 0) {
                link_->read(reception_, now_, now_.time_since_epoch());
            }
            link_->poll(now_);
        } while (kernel.count > 0);
    }

    std::unique_ptr<CanSocket> link_;
    CanReception reception_;
    std::array<CanFrame, kFrames> snapshot_{};
    Instant now_ = Instant(std::chrono::hours(1));
    std::uint64_t units_ = 0;
};

}  // namespace
}  // namespace tribus

extern "C" {

int sendmmsg(int /*socket*/, mmsghdr* messages, unsigned count, int /*flags*/) {
    return tribus::taken_by_kernel(messages, count);
}

int recvmmsg(int /*socket*/, mmsghdr* messages, unsigned count, int /*flags*/,
             timespec* /*timeout*/) {
    return tribus::given_by_kernel(messages, count);
}

int getsockopt(int /*socket*/, int /*level*/, int /*option*/, void* value,
               socklen_t* size) noexcept {
    ++tribus::kernel.calls;
    std::memset(value, 0, *size);
    return 0;
}

ssize_t recv(int /*socket*/, void* /*bytes*/, std::size_t /*size*/, int /*flags*/) {
    ++tribus::kernel.calls;
    errno = EAGAIN;
    return -1;
}

}  // extern "C"

int main(int words, char** word) {
    if (words < 3) {
        return 2;
    }
    const std::string_view workload = word[1];
    tribus::Driver driver(workload == "out_with_echo");
    const std::size_t units = std::strtoul(word[2], nullptr, 10);
    for (std::size_t unit = 0; unit < units; ++unit) {
        workload == "in" ? driver.receive() : driver.send();
    }
    std::printf("calls %llu\n", static_cast<unsigned long long>(tribus::kernel.calls));
    return driver.works() ? 0 : 1;
}
