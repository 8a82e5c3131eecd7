#include "transports/codecs/dronecan/transfer.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace tribus::dronecan {
namespace {

/// Specification 4.1, "Transfer ID timeout" (docs/protocols/can.md, "DroneCAN: transport").
constexpr Duration kTransferTimeout = std::chrono::seconds(2);

constexpr std::size_t kMostFdCarried = kMostFdBytes - 1;

std::uint8_t tail_of(const CanFrame& frame) {
    return frame.data[frame.length - 1U];
}
std::uint8_t transfer_id_of(const CanFrame& frame) {
    return tail_of(frame) & kTailTransferId;
}
bool has(const CanFrame& frame, std::uint8_t tail_bit) {
    return (tail_of(frame) & tail_bit) != 0;
}
bool is_single(const CanFrame& frame) {
    return has(frame, kTailStart) && has(frame, kTailEnd);
}
std::span<const std::uint8_t> carried_by(const CanFrame& frame) {
    return frame.bytes().first(frame.length - 1U);
}

std::uint8_t next_transfer_id(std::uint8_t transfer_id) {
    return (transfer_id + 1U) & kTailTransferId;
}

/// How many steps forward lead from one id to the other.
unsigned forward_distance(std::uint8_t from, std::uint8_t to) {
    return (unsigned{to} - unsigned{from}) & kTailTransferId;
}

/// Bytes that the frames carry, including the padding of the last one.
std::size_t padded(std::size_t bytes, bool fd) {
    const std::size_t in_last = bytes % kMostFdCarried;
    return fd ? bytes - in_last + can_length_for(in_last + 1) - 1 : bytes;
}

/// Bytes that a session keeps of a transfer.
std::size_t room_for(std::size_t most_bytes) {
    return padded(most_bytes + kCrcBytes, true);
}

bool crc_is_right(std::uint64_t signature, std::span<const std::uint8_t> with_crc) {
    const unsigned stated = with_crc[0] | unsigned{with_crc[1]} << 8U;
    return stated == transfer_crc(signature, with_crc.subspan(kCrcBytes));
}

}  // namespace

TransferReceiver::TransferReceiver(std::vector<WantedTransfer> wanted, std::size_t most_senders)
    : wanted_(std::move(wanted)), most_senders_(most_senders) {
    std::size_t total = kMostFdCarried;
    for (const WantedTransfer& each : wanted_) {
        total += room_for(each.most_bytes) * most_senders_;
    }
    room_.resize(total);
    std::span<std::uint8_t> rest = room_;
    const auto take_room = [&rest](std::size_t bytes) {
        const std::span<std::uint8_t> room = rest.first(bytes);
        rest = rest.subspan(bytes);
        return room;
    };
    anonymous_.room = take_room(kMostFdCarried);
    sessions_.resize(wanted_.size() * most_senders_);
    for (std::size_t place = 0; place < sessions_.size(); ++place) {
        sessions_[place].room = take_room(room_for(wanted_[place / most_senders_].most_bytes));
    }
}

TransferReceiver::Taken TransferReceiver::take(const CanFrame& frame, Instant at) {
    Taken taken = judge(frame, at);
    ++counts_[static_cast<std::size_t>(taken.result)];
    broken_off_ += taken.broke_off ? 1U : 0U;
    return taken;
}

TransferReceiver::Taken TransferReceiver::judge(const CanFrame& frame, Instant at) {
    Taken taken;
    const std::optional<TransferHead> head = head_of(frame);
    if (!head) {
        return taken;
    }
    const std::size_t index = wanted_index(*head);
    if (index == wanted_.size()) {
        taken.result = FrameResult::unwanted;
        return taken;
    }
    const bool anonymous = head->source == kNobody;
    Session* session = anonymous ? &anonymous_ : session_for(index, *head, at);
    if (session == nullptr) {
        taken.result = FrameResult::crowded_out;
        return taken;
    }
    if (anonymous) {
        session->begin(head->transfer_id, frame.fd, at);
        taken.result = FrameResult::taken;
    } else {
        taken.result = has(frame, kTailStart) ? session->start(frame, at, taken.broke_off)
                                              : session->follow(frame, at, taken.broke_off);
    }
    const WantedTransfer& wanted = wanted_[index];
    if (taken.result == FrameResult::taken) {
        taken.result = session->add(frame, wanted.most_bytes);
    }
    if (taken.result != FrameResult::complete) {
        return taken;
    }
    std::span<const std::uint8_t> payload = session->room.first(session->size);
    if (!is_single(frame)) {
        if (!crc_is_right(wanted.signature, payload)) {
            taken.result = FrameResult::bad_crc;
            return taken;
        }
        payload = payload.subspan(kCrcBytes);
    }
    taken.transfer =
        ReceivedTransfer{.head = *head,
                         .fd = frame.fd,
                         .first_at = session->first_at,
                         .payload = payload.first(std::min(payload.size(), wanted.most_bytes))};
    return taken;
}

std::size_t TransferReceiver::wanted_index(const TransferHead& head) const {
    const bool to_another =
        head.kind != TransferKind::message && own_ != kNobody && head.destination != own_;
    std::size_t index = 0;
    while (index < wanted_.size() && (to_another || wanted_[index].kind != head.kind ||
                                      wanted_[index].data_type_id != head.data_type_id)) {
        ++index;
    }
    return index;
}

TransferReceiver::Session* TransferReceiver::session_for(std::size_t index,
                                                         const TransferHead& head, Instant at) {
    const std::span places = std::span(sessions_).subspan(index * most_senders_, most_senders_);
    Session* free = nullptr;
    for (Session& session : places) {
        if (session.used && session.source == head.source &&
            session.destination == head.destination) {
            return &session;
        }
        if (free == nullptr && session.forgotten(at)) {
            free = &session;
        }
    }
    if (free != nullptr) {
        broken_off_ += free->collecting ? 1U : 0U;
        *free = {.source = head.source, .destination = head.destination, .room = free->room};
    }
    return free;
}

bool TransferReceiver::Session::forgotten(Instant at) const {
    return !used || at > later(first_at, kTransferTimeout);
}

void TransferReceiver::Session::begin(std::uint8_t id, bool in_fd_frames, Instant at) {
    used = true;
    transfer_id = id;
    collecting = true;
    too_long = false;
    toggle = false;
    fd = in_fd_frames;
    first_at = at;
    size = 0;
}

bool TransferReceiver::Session::ends_in(std::span<const std::uint8_t> bytes) const {
    return bytes.size() <= size && std::ranges::equal(room.first(size).last(bytes.size()), bytes);
}

/// A start of the previous transfer, or of the one in progress, is a copy.
FrameResult TransferReceiver::Session::start(const CanFrame& frame, Instant at, bool& broke_off) {
    const std::uint8_t id = transfer_id_of(frame);
    const unsigned behind = forward_distance(id, transfer_id);
    if (!forgotten(at) && (behind == 1 || (behind == 0 && collecting))) {
        return FrameResult::repeated;
    }
    broke_off = collecting;
    begin(id, frame.fd, at);
    return FrameResult::taken;
}

FrameResult TransferReceiver::Session::follow(const CanFrame& frame, Instant at, bool& broke_off) {
    if (forgotten(at)) {
        broke_off = collecting;
        collecting = false;
        return FrameResult::out_of_turn;
    }
    const unsigned behind = forward_distance(transfer_id_of(frame), transfer_id);
    if (behind == 1) {
        return FrameResult::repeated;
    }
    if (behind != 0 || !collecting || frame.fd != fd) {
        return FrameResult::out_of_turn;
    }
    if (has(frame, kTailToggle) != toggle) {
        return ends_in(carried_by(frame)) ? FrameResult::repeated : FrameResult::out_of_turn;
    }
    return FrameResult::taken;
}

FrameResult TransferReceiver::Session::add(const CanFrame& frame, std::size_t most_bytes) {
    const std::span<const std::uint8_t> more = carried_by(frame);
    const std::size_t limit = padded(most_bytes + (is_single(frame) ? 0 : kCrcBytes), fd);
    too_long = too_long || more.size() > limit - size;
    if (!too_long) {
        std::ranges::copy(more, room.subspan(size).begin());
        size += more.size();
    }
    toggle = !toggle;
    if (has(frame, kTailEnd)) {
        collecting = false;
        transfer_id = next_transfer_id(transfer_id);
    }
    if (too_long) {
        return FrameResult::too_long;
    }
    return has(frame, kTailEnd) ? FrameResult::complete : FrameResult::taken;
}

}  // namespace tribus::dronecan
