#include "transports/links/can/can_socket.h"

#include <linux/can/raw.h>
#include <net/if.h>
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
    struct alignas(cmsghdr) Control {
        std::array<std::uint8_t, kControlBytes> bytes{};
    };
    std::array<canfd_frame, kCanFramesPerRead> frames{};
    std::array<iovec, kCanFramesPerRead> vectors{};
    std::array<Control, kCanFramesPerRead> controls{};
    std::array<mmsghdr, kCanFramesPerRead> headers{};
    std::size_t used = 0;  ///< headers that the latest read changed
    std::array<canfd_frame, kMostSnapshotFrames> sent_frames{};
    std::array<iovec, kMostSnapshotFrames> sent_vectors{};
    std::array<mmsghdr, kMostSnapshotFrames> sent_headers{};

    Buffers() {
        for (std::size_t index = 0; index < headers.size(); ++index) {
            vectors[index] = {.iov_base = &frames[index], .iov_len = sizeof(canfd_frame)};
            headers[index].msg_hdr.msg_iov = &vectors[index];
            headers[index].msg_hdr.msg_iovlen = 1;
            headers[index].msg_hdr.msg_control = controls[index].bytes.data();
            headers[index].msg_hdr.msg_controllen = kControlBytes;
        }
        for (std::size_t index = 0; index < sent_headers.size(); ++index) {
            sent_vectors[index].iov_base = &sent_frames[index];
            sent_headers[index].msg_hdr.msg_iov = &sent_vectors[index];
            sent_headers[index].msg_hdr.msg_iovlen = 1;
        }
    }

    /// The kernel writes into the headers of what it returns.
    void prepare_read() {
        for (std::size_t index = 0; index < used; ++index) {
            headers[index].msg_hdr.msg_controllen = kControlBytes;
        }
        used = 0;
    }
    void prepare_to_send(std::span<const CanFrame> snapshot) {
        for (std::size_t index = 0; index < snapshot.size(); ++index) {
            sent_vectors[index].iov_len = to_wire(snapshot[index], sent_frames[index]);
        }
    }
};

CanSocket::CanSocket(UniqueFd fd, UniqueFd changes, CanInterface interface)
    : fd_(std::move(fd)),
      changes_(std::move(changes)),
      interface_(std::move(interface)),
      is_up_(interface_.up),
      is_running_(interface_.running),
      transmitter_(counts_, interface_.echo),
      buffers_(std::make_unique<Buffers>()) {
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
    return is_can_interface_missing(interface);
}

ReadStatus CanSocket::read(CanReception& reception, Instant now, Duration wall_time) {
    reception.count = 0;
    reception.full = false;
    if (lost_) {
        return ReadStatus::lost;
    }
    buffers_->prepare_read();
    stamps_usable_ = !clock_step_.since_last_look(wall_time, now);
    const int taken =
        ::recvmmsg(fd_.get(), buffers_->headers.data(), kCanFramesPerRead, MSG_DONTWAIT, nullptr);
    if (taken < 0) {
        return read_failed(errno, now, wall_time);
    }
    const auto count = static_cast<std::size_t>(taken);
    buffers_->used = count;
    for (std::size_t index = 0; index < count; ++index) {
        if (const auto received = process(index, now, wall_time)) {
            reception.frames[reception.count] = *received;
            ++reception.count;
        }
    }
    // After the frames were read: if the name is still that of this interface, it was so when they
    // came.
    if (reception.count > 0) {
        read_changes(now);
    }
    if (lost_) {
        reception.count = 0;
        return ReadStatus::lost;
    }
    reception.full = count == kCanFramesPerRead;
    if (reception.full) {
        drops_unread_ = true;
    } else {
        emptied(now, wall_time);
    }
    counts_.received += reception.count;
    // A confirmation lets the next snapshot go without waiting for another wake-up.
    pump(now);
    return reception.count > 0 ? ReadStatus::received : ReadStatus::nothing;
}

void CanSocket::emptied(Instant now, Duration wall_time) {
    emptied_ = now;
    clock_step_.look(wall_time, now);
    // A frame tells the drops before it. Those after the last one are asked for.
    if (std::exchange(drops_unread_, false)) {
        note_drops(kernel_queues().drops);
    }
}

ReadStatus CanSocket::read_failed(int error, Instant now, Duration wall_time) {
    if (error == EAGAIN) {
        emptied(now, wall_time);
        read_changes(now);
        return lost_ ? ReadStatus::lost : ReadStatus::nothing;
    }
    if (error == ENETDOWN) {
        // Reported once. The same socket works again when the interface is up
        // (docs/protocols/can.md, "SocketCAN: loss and errors").
        went_down();
        read_changes(now);
    } else if (interface_is_gone(error)) {
        lost_ = true;
    }
    return lost_ ? ReadStatus::lost : ReadStatus::nothing;
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
        if (interface_.echo) {
            transmitter_.confirmed(*frame, now);
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
    if (!lost_ && !up_since_) {
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
    const auto rechecks = [this] { return !works() || awaits_carrier_; };
    if (rechecks() && now >= later(checked_, kRecheckPeriod)) {
        recheck(now);
    }
    pump(now);
    Instant due = transmitter_.due();
    if (transmitter_.in_flight() && !interface_.echo) {
        due = std::min(due, later(now, kQueueCheckPeriod));
    }
    if (rechecks()) {
        due = std::min(due, later(checked_, kRecheckPeriod));
    }
    return lost_ ? kNever : due;
}

void CanSocket::pump(Instant now) {
    bool looked = false;
    // Each turn but the look hands over a waiting frame, so there cannot be more turns than this.
    for (std::size_t turn = 0; turn <= kMostLanes * kMostSnapshotFrames && !lost_; ++turn) {
        if (transmitter_.in_flight() && !flight_is_over(now)) {
            return;
        }
        const std::span<const CanFrame> frames = transmitter_.next(now);
        if (frames.empty()) {
            return;
        }
        // Last before they leave: the name may be that of another bus now.
        if (!std::exchange(looked, true) && read_changes(now)) {
            continue;
        }
        send(frames, now);
    }
}

void CanSocket::send(std::span<const CanFrame> frames, Instant now) {
    buffers_->prepare_to_send(frames);
    drops_when_handed_ = drops_;
    const int sent = ::sendmmsg(fd_.get(), buffers_->sent_headers.data(),
                                static_cast<unsigned>(frames.size()), MSG_DONTWAIT);
    if (sent < 0) {
        send_failed(errno, now);
    } else {
        transmitter_.handed(static_cast<std::size_t>(sent), now);
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
        transmitter_.confirmed_all();
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

}  // namespace tribus
