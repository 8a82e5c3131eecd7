#include "transports/links/can/can_socket.h"

#include <linux/can/raw.h>
#include <linux/sock_diag.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/uio.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <utility>

#include "transports/links/can/can_wire.h"

namespace tribus {

namespace {

bool interface_is_gone(int error) {
    return error == ENODEV || error == ENXIO || error == EBADF;
}

/// Room for a time stamp and a count of drops.
constexpr std::size_t kControlBytes =
    CMSG_SPACE(sizeof(timespec)) + CMSG_SPACE(sizeof(std::uint32_t));

/// Control data of a received frame.
struct Side {
    std::optional<Duration> stamp;  ///< since 1970
    std::optional<std::uint32_t> drops;
};

Side side_of(msghdr& header) {
    Side side;
    for (cmsghdr* item = CMSG_FIRSTHDR(&header); item != nullptr;
         item = CMSG_NXTHDR(&header, item)) {
        if (item->cmsg_level != SOL_SOCKET) {
            continue;
        }
        if (item->cmsg_type == SCM_TIMESTAMPNS) {
            timespec stamp{};
            std::memcpy(&stamp, CMSG_DATA(item), sizeof stamp);
            side.stamp =
                std::chrono::seconds(stamp.tv_sec) + std::chrono::nanoseconds(stamp.tv_nsec);
        } else if (item->cmsg_type == SO_RXQ_OVFL) {
            std::uint32_t drops = 0;
            std::memcpy(&drops, CMSG_DATA(item), sizeof drops);
            side.drops = drops;
        }
    }
    return side;
}

}  // namespace

/// Outside the object because of its size and its system headers.
struct CanSocket::Buffers {
    std::array<canfd_frame, kCanFramesPerRead> frames{};
    std::array<iovec, kCanFramesPerRead> vectors{};
    struct alignas(cmsghdr) Control {
        std::array<std::uint8_t, kControlBytes> bytes{};
    };
    std::array<Control, kCanFramesPerRead> controls{};
    std::array<mmsghdr, kCanFramesPerRead> headers{};
    ifreq line{};

    /// The kernel writes into the headers, so they are reset before each read.
    void prepare() {
        for (std::size_t index = 0; index < headers.size(); ++index) {
            vectors[index] = {.iov_base = &frames[index], .iov_len = sizeof(canfd_frame)};
            msghdr& header = headers[index].msg_hdr;
            header = {};
            header.msg_iov = &vectors[index];
            header.msg_iovlen = 1;
            header.msg_control = controls[index].bytes.data();
            header.msg_controllen = controls[index].bytes.size();
        }
    }
};

CanSocket::CanSocket(UniqueFd fd, CanInterface interface)
    : fd_(std::move(fd)), interface_(std::move(interface)), buffers_(std::make_unique<Buffers>()) {
    interface_.name.copy(std::begin(buffers_->line.ifr_name), IFNAMSIZ - 1);
    if (interface_.state == CanControllerState::bus_off) {
        transmitter_.bus_off(Instant{});
    } else if (!interface_.up || !interface_.lower_up) {
        transmitter_.went_down();
    } else if (interface_.state == CanControllerState::passive) {
        transmitter_.error_level(CanTransmitter::ErrorLevel::passive);
    } else if (interface_.state == CanControllerState::warning) {
        transmitter_.error_level(CanTransmitter::ErrorLevel::warning);
    }
}

CanSocket::~CanSocket() = default;

bool CanSocket::is_missing(const std::string& interface) {
    return !interface.empty() && interface.size() < IFNAMSIZ &&
           ::if_nametoindex(interface.c_str()) == 0 && errno == ENODEV;
}

ReadStatus CanSocket::read(CanReception& reception, Instant now, Duration wall_time) {
    reception.count = 0;
    reception.full = false;
    if (lost_) {
        return ReadStatus::lost;
    }
    buffers_->prepare();
    stamps_usable_ = !clock_step_.since_last_look(wall_time, now);
    const int taken =
        ::recvmmsg(fd_.get(), buffers_->headers.data(), kCanFramesPerRead, MSG_DONTWAIT, nullptr);
    if (taken < 0) {
        return read_failed(errno, now, wall_time);
    }
    const auto count = static_cast<std::size_t>(taken);
    for (std::size_t index = 0; index < count; ++index) {
        if (const auto received = process(index, now, wall_time)) {
            reception.frames[reception.count] = *received;
            ++reception.count;
        }
    }
    reception.full = count == kCanFramesPerRead;
    if (!reception.full) {
        emptied_ = now;
        clock_step_.look(wall_time, now);
    }
    counts_.received += reception.count;
    // A confirmation lets the next frame go without waiting for another wake-up.
    pump(now);
    return reception.count > 0 ? ReadStatus::received : ReadStatus::nothing;
}

ReadStatus CanSocket::read_failed(int error, Instant now, Duration wall_time) {
    if (error == EAGAIN) {
        emptied_ = now;
        clock_step_.look(wall_time, now);
    } else if (error == ENETDOWN) {
        // Reported once. The same socket works again when the interface is up
        // (docs/protocols/can.md, "SocketCAN: loss and errors").
        went_down();
    } else if (interface_is_gone(error)) {
        lost_ = true;
        return ReadStatus::lost;
    }
    return ReadStatus::nothing;
}

std::optional<ReceivedCanFrame> CanSocket::process(std::size_t index, Instant now,
                                                   Duration wall_time) {
    mmsghdr& message = buffers_->headers[index];
    const canfd_frame& wire = buffers_->frames[index];
    const Side side = side_of(message.msg_hdr);
    if (side.drops) {
        note_drops(*side.drops);
    }
    if ((wire.can_id & CAN_ERR_FLAG) != 0) {
        process_error(wire, now);
        return std::nullopt;
    }
    const auto frame = from_wire(wire, message.msg_len);
    if (!frame) {
        return std::nullopt;
    }
    if ((message.msg_hdr.msg_flags & MSG_CONFIRM) != 0) {
        const CanFrame* flight = transmitter_.in_flight();
        if (interface_.echo && flight != nullptr && same_message(*flight, *frame)) {
            transmitter_.confirmed();
        }
        return std::nullopt;
    }
    const bool local = (message.msg_hdr.msg_flags & MSG_DONTROUTE) != 0;
    if (!local && !no_carrier_) {
        transmitter_.alive(now);
    }
    const Arrival arrival =
        plausible_arrival(side.stamp, wall_time, now, emptied_.value_or(now - kMostPlausibleAge));
    const bool plausible = arrival.plausible && stamps_usable_;
    counts_.implausible_times += plausible ? 0 : 1;
    if (!plausible && !emptied_) {
        // Nothing has been read before, so the frame may be of any age.
        return std::nullopt;
    }
    return ReceivedCanFrame{.frame = *frame,
                            .at = plausible ? arrival.at : *emptied_,
                            .sender = local ? CanSender::local : CanSender::bus};
}

void CanSocket::process_error(const canfd_frame& wire, Instant now) {
    using ErrorLevel = CanTransmitter::ErrorLevel;
    const CanErrorReport report = error_report(wire).value_or(CanErrorReport{});
    ++counts_.error_frames;
    counts_.missing_acknowledges += report.no_acknowledge ? 1 : 0;
    counts_.receive_overflows += report.receive_overflow ? 1 : 0;
    if (report.passive) {
        transmitter_.error_level(ErrorLevel::passive);
    } else if (report.warning) {
        transmitter_.error_level(ErrorLevel::warning);
    } else if (report.active) {
        transmitter_.error_level(ErrorLevel::active);
    }
    if ((report.active || report.warning || report.passive) && !no_carrier_) {
        transmitter_.alive(now);
    }
    if (report.bus_off) {
        transmitter_.bus_off(now);
        // Without confirmations, nothing reports what happens to a frame that left the queue.
        if (!interface_.echo && kernel_queues().sending == 0) {
            transmitter_.forget_flight();
        }
    }
    if (report.restarted) {
        no_carrier_ = false;
        transmitter_.restarted(now);
    }
}

void CanSocket::note_drops(std::uint32_t drops) {
    counts_.receive_overflows += drops - drops_;
    drops_ = drops;
}

WriteStatus CanSocket::write(std::size_t lane, std::span<const CanFrame> snapshot, Instant now) {
    if (!lost_) {
        check_line(now);
    }
    if (lost_) {
        return WriteStatus::lost;
    }
    if (no_carrier_) {
        return WriteStatus::unavailable;
    }
    const WriteStatus status = transmitter_.offer(lane, snapshot, now);
    pump(now);
    if (lost_) {
        return WriteStatus::lost;
    }
    return works() ? status : WriteStatus::unavailable;
}

Instant CanSocket::poll(Instant now) {
    if (lost_) {
        return kNever;
    }
    transmitter_.poll(now);
    if (!works() && now >= later(checked_, kRecheckPeriod)) {
        recheck(now);
    }
    pump(now);
    Instant due = transmitter_.due();
    if (transmitter_.in_flight() != nullptr && !interface_.echo) {
        due = std::min(due, later(now, kQueueCheckPeriod));
    }
    if (!works()) {
        due = std::min(due, later(checked_, kRecheckPeriod));
    }
    return lost_ ? kNever : due;
}

bool CanSocket::works() const {
    const CanBusState state = transmitter_.state();
    return state != CanBusState::down && state != CanBusState::bus_off &&
           state != CanBusState::stalled;
}

void CanSocket::pump(Instant now) {
    // Each turn hands over a waiting frame, so there cannot be more turns than this.
    for (std::size_t turn = 0; turn < kMostLanes * kMostSnapshotFrames && !lost_; ++turn) {
        if (transmitter_.in_flight() != nullptr && !flight_is_over(now)) {
            return;
        }
        const CanFrame* frame = transmitter_.next(now);
        if (frame == nullptr) {
            return;
        }
        const WireCanFrame wire = to_wire(*frame);
        if (interface_.echo) {
            drops_when_handed_ = kernel_queues().drops;
        }
        if (::send(fd_.get(), &wire.frame, wire.size, MSG_DONTWAIT) < 0) {
            send_failed(errno, now);
        } else {
            transmitter_.handed(now);
        }
    }
}

bool CanSocket::flight_is_over(Instant now) {
    if (interface_.echo || kernel_queues().sending > 0) {
        return false;
    }
    if (transmitter_.state() == CanBusState::bus_off) {
        check_line(now);
    }
    // An interface without carrier also empties its queue.
    if (no_carrier_) {
        transmitter_.forget_flight();
    } else {
        transmitter_.confirmed();
    }
    return true;
}

void CanSocket::send_failed(int error, Instant now) {
    if (error == ENOBUFS || error == EAGAIN) {
        transmitter_.refused_full(now);
    } else if (error == ENETDOWN) {
        went_down();
    } else if (interface_is_gone(error)) {
        lost_ = true;
    } else {
        transmitter_.refused();
    }
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
/// "SocketCAN: transmit queue"). A controller has a carrier while it is up, except in bus-off.
void CanSocket::check_line(Instant now) {
    checked_ = now;
    if (::ioctl(fd_.get(), SIOCGIFFLAGS, &buffers_->line) != 0) {
        lost_ = lost_ || interface_is_gone(errno);
        return;
    }
    const auto flags = static_cast<unsigned>(buffers_->line.ifr_flags);
    const bool up = (flags & IFF_UP) != 0;
    const bool runs = up && (flags & IFF_RUNNING) != 0;
    if (up && !up_since_) {
        up_since_ = now;
    }
    if (runs) {
        transmitter_.came_up(now);
        if (std::exchange(no_carrier_, false)) {
            transmitter_.restarted(now);
        }
    } else if (!up || interface_.kind != "can") {
        went_down();
    } else if (transmitter_.state() != CanBusState::bus_off &&
               now < later(*up_since_, kCarrierLag)) {
        transmitter_.came_up(now);
    } else {
        no_carrier_ = true;
        transmitter_.bus_off(now);
    }
}

void CanSocket::went_down() {
    up_since_.reset();
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
