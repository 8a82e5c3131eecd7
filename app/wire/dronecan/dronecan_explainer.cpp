#include "app/wire/dronecan/dronecan_explainer.h"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <span>
#include <utility>

namespace tribus {
namespace {

using dronecan::FrameResult;
using dronecan::KnownPayload;
using dronecan::TransferHead;
using dronecan::TransferKind;

/// For unknown types; longer than any type in use.
constexpr std::size_t kMostUnknownBytes = 1024;
/// 127 nodes with 30 types each; about 4 MB.
constexpr std::size_t kMostSessions = 4096;
constexpr std::size_t kMostStreams = 4096;
constexpr std::size_t kMostCalls = 4096;
/// A transfer ends if its next frame does not come within this time (specification 4.1).
constexpr Duration kTransferTimeout = std::chrono::seconds(2);
/// A client waits no longer for a response (specification 4.1).
constexpr Duration kServiceTimeout = std::chrono::seconds(1);
constexpr std::size_t kCrcBytes = 2;

std::uint8_t tail_of(const CanFrame& frame) {
    return frame.data[frame.length - 1U];
}
bool has(const CanFrame& frame, std::uint8_t tail_bit) {
    return (tail_of(frame) & tail_bit) != 0;
}

dronecan::WantedTransfer wanted(const TransferHead& head, const KnownPayload* type) {
    return {.kind = head.kind,
            .data_type_id = head.data_type_id,
            .signature = type == nullptr ? 0 : type->type.signature,
            .most_bytes = type == nullptr ? kMostUnknownBytes : type->most_bytes};
}

bool layout_is_right(const ExplainedTransfer& transfer) {
    return transfer.type == nullptr ||
           transfer.type->visit(transfer.payload, transfer.fd, [](const dronecan::FieldValue&) {});
}

}  // namespace

DroneCanExplainer::Session::Session(const TransferHead& head)
    : type(dronecan::find_known_payload(head.kind, head.data_type_id)),
      receiver({wanted(head, type)}, 1) {}

void DroneCanExplainer::Part::begin(const TransferHead& begun, const RecordedCanFrame& recorded) {
    open = true;
    has_start = has(recorded.frame, dronecan::kTailStart);
    single = has_start && has(recorded.frame, dronecan::kTailEnd);
    disturbed = false;
    head = begun;
    fd = recorded.frame.fd;
    frames = 0;
    first_at = recorded.at;
    bytes.clear();
}

void DroneCanExplainer::Part::add(const RecordedCanFrame& recorded) {
    const auto carried = recorded.frame.bytes().first(recorded.frame.length - 1U);
    ++frames;
    last_at = recorded.at;
    if (bytes.size() <= kMostUnknownBytes) {
        bytes.insert(bytes.end(), carried.begin(), carried.end());
    }
}

void DroneCanExplainer::feed(const RecordedCanFrame& recorded) {
    const CanFrame& frame = recorded.frame;
    latest_ = recorded.at;
    ++tally_.can_frames;
    tally_.bytes += frame.remote ? 0 : frame.length;
    const auto head = dronecan::head_of(frame);
    if (!head) {
        ++tally_.other_can_frames;
        return;
    }
    Session* const session = session_of(*head, recorded.at);
    if (session != nullptr) {
        session->last_at = recorded.at;
        take(*session, *head, recorded);
    } else if (has(frame, dronecan::kTailStart)) {
        Part part;
        part.begin(*head, recorded);
        part.add(recorded);
        report(part, dronecan::find_known_payload(head->kind, head->data_type_id),
               TransferFault::crowded_out);
    }
}

DroneCanExplainer::Session* DroneCanExplainer::session_of(const TransferHead& head, Duration now) {
    const Key key{head.kind, head.data_type_id, head.source, head.destination};
    const auto found = sessions_.find(key);
    if (found != sessions_.end()) {
        return &found->second;
    }
    if (sessions_.size() >= kMostSessions) {
        forget_silent_ones(now);
    }
    return sessions_.size() < kMostSessions ? &sessions_.try_emplace(key, head).first->second
                                            : nullptr;
}

void DroneCanExplainer::forget_silent_ones(Duration now) {
    for (auto entry = sessions_.begin(); entry != sessions_.end();) {
        const bool silent = now - entry->second.last_at > kTransferTimeout;
        if (silent) {
            end_unfinished(entry->second, now);
        }
        entry = silent ? sessions_.erase(entry) : std::next(entry);
    }
}

void DroneCanExplainer::take(Session& session, const TransferHead& head,
                             const RecordedCanFrame& recorded) {
    const auto taken = session.receiver.take(recorded.frame, Instant(recorded.at));
    if (taken.broke_off) {
        end_current(session, TransferFault::broke_off);
    }
    switch (taken.result) {
        case FrameResult::taken:
        case FrameResult::complete:
        case FrameResult::bad_crc:
        case FrameResult::too_long:
            collect(session, head, recorded, taken.result);
            break;
        case FrameResult::repeated:
            ++tally_.repeated_frames;
            if (!session.current.open) {
                collect_stray(session, head, recorded, TransferFault::repeated);
            }
            break;
        case FrameResult::out_of_turn:
            if (session.current.open && session.current.head.transfer_id == head.transfer_id) {
                session.current.disturbed = true;
                ++session.current.frames;
                session.current.last_at = recorded.at;
            } else {
                collect_stray(session, head, recorded, TransferFault::start_missing);
            }
            break;
        case FrameResult::foreign:
        case FrameResult::unwanted:
        case FrameResult::crowded_out:
            break;
    }
}

void DroneCanExplainer::collect(Session& session, const TransferHead& head,
                                const RecordedCanFrame& recorded, FrameResult result) {
    Part& current = session.current;
    if (has(recorded.frame, dronecan::kTailStart)) {
        end_stray(session);
        current.begin(head, recorded);
    }
    current.add(recorded);
    if (!has(recorded.frame, dronecan::kTailEnd)) {
        return;
    }
    // The receiver does not know the signature of an unknown type.
    const bool crc_wrong = result == FrameResult::bad_crc && session.type != nullptr;
    if (result == FrameResult::too_long) {
        end_current(session, TransferFault::too_long);
    } else if (crc_wrong || (result == FrameResult::bad_crc && current.disturbed)) {
        end_current(session, TransferFault::bad_crc);
    } else {
        end_current(session, TransferFault::none);
    }
}

/// Reports copies only if they are complete transfers.
void DroneCanExplainer::collect_stray(Session& session, const TransferHead& head,
                                      const RecordedCanFrame& recorded, TransferFault fault) {
    Part& stray = session.stray;
    const bool starts = has(recorded.frame, dronecan::kTailStart);
    const bool goes_on = stray.open && !starts && session.stray_fault == fault &&
                         stray.head.transfer_id == head.transfer_id;
    if (!goes_on) {
        end_stray(session);
        if (fault == TransferFault::repeated && !starts) {
            return;
        }
        stray.begin(head, recorded);
        session.stray_fault = fault;
    }
    stray.add(recorded);
    if (has(recorded.frame, dronecan::kTailEnd)) {
        end_stray(session);
    }
}

void DroneCanExplainer::end_current(Session& session, TransferFault fault) {
    Part& current = session.current;
    if (!std::exchange(current.open, false)) {
        return;
    }
    const bool lost_one =
        current.disturbed && fault != TransferFault::none && fault != TransferFault::too_long;
    report(current, session.type, lost_one ? TransferFault::frames_missing : fault);
}

void DroneCanExplainer::end_stray(Session& session) {
    if (std::exchange(session.stray.open, false)) {
        report(session.stray, session.type, session.stray_fault);
    }
}

void DroneCanExplainer::end_unfinished(Session& session, Duration now) {
    const bool over = now - session.current.first_at > kTransferTimeout;
    end_current(session, over ? TransferFault::broke_off : TransferFault::cut);
    end_stray(session);
}

void DroneCanExplainer::finish() {
    for (auto& [key, session] : sessions_) {
        end_unfinished(session, latest_);
    }
}

void DroneCanExplainer::report(const Part& part, const KnownPayload* type, TransferFault fault) {
    ExplainedTransfer transfer{.first_at = part.first_at,
                               .last_at = part.last_at,
                               .head = part.head,
                               .fd = part.fd,
                               .frames = part.frames,
                               .type = type,
                               .fault = fault,
                               .payload = part.bytes,
                               .answered_after = {}};
    if (part.has_start && !part.single) {
        const auto crc_end = std::min(kCrcBytes, transfer.payload.size());
        transfer.payload.erase(transfer.payload.begin(),
                               transfer.payload.begin() + static_cast<std::ptrdiff_t>(crc_end));
        transfer.crc_unchecked = type == nullptr && fault == TransferFault::none;
    }
    if (type != nullptr && part.fd) {
        transfer.payload.resize(std::min(transfer.payload.size(), type->most_bytes));
    }
    if (fault == TransferFault::none && !layout_is_right(transfer)) {
        transfer.fault = TransferFault::layout;
    }
    transfer.answered_after = pair(transfer);
    count(transfer);
    handler_(transfer);
}

std::optional<Duration> DroneCanExplainer::pair(const ExplainedTransfer& transfer) {
    const TransferHead& head = transfer.head;
    if (transfer.fault != TransferFault::none || head.kind == TransferKind::message) {
        return std::nullopt;
    }
    if (head.kind == TransferKind::request) {
        ++tally_.requests;
        if (calls_.size() >= kMostCalls) {
            std::erase_if(calls_, [&](const auto& call) {
                return transfer.last_at - call.second > kServiceTimeout;
            });
        }
        if (calls_.size() < kMostCalls) {
            calls_[{head.source, head.destination, head.data_type_id, head.transfer_id}] =
                transfer.last_at;
        }
        return std::nullopt;
    }
    ++tally_.responses;
    const auto call =
        calls_.find({head.destination, head.source, head.data_type_id, head.transfer_id});
    if (call == calls_.end()) {
        return std::nullopt;
    }
    ++tally_.answered;
    const Duration after = transfer.last_at - call->second;
    calls_.erase(call);
    return after;
}

void DroneCanExplainer::count(const ExplainedTransfer& transfer) {
    const auto fault = static_cast<std::size_t>(transfer.fault);
    ++tally_.counts.at(fault);
    tally_.of_known_type +=
        transfer.type != nullptr && transfer.fault == TransferFault::none ? 1U : 0U;
    const TransferStream stream{transfer.head.source, transfer.head.kind,
                                transfer.head.data_type_id};
    const auto found = tally_.streams.find(stream);
    if (found != tally_.streams.end()) {
        ++found->second.at(fault);
    } else if (tally_.streams.size() < kMostStreams) {
        ++tally_.streams[stream].at(fault);
    }
}

}  // namespace tribus
