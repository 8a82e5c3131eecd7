#include "app/wire/dronecan/dronecan_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <iterator>

#include "app/wire/dronecan/dronecan_fields.h"
#include "app/wire/frames/frame_json.h"
#include "app/wire/frames/frame_text.h"
#include "core/counted.h"

namespace tribus {
namespace {

using dronecan::TransferKind;

/// In the order of TransferFault.
constexpr std::array<std::string_view, kTransferFaultCount> kFaultTexts{
    "",
    "bad CRC: damaged, or the sender's type has another signature",
    "a frame is missing within it",
    "its first frame is missing",
    "broke off: its last frame never came",
    "the recording ends in it",
    "longer than its type can be",
    "the payload does not fit its type",
    "repeated: sent again with the transfer id of the one before",
    "not decoded: too many senders and types at the same time"};

/// Continuation lines are indented to the type.
constexpr std::size_t kIndent = 31;
/// Narrower terminals get a smaller indentation.
constexpr std::size_t kLeastText = 40;
constexpr std::size_t kNarrowIndent = 4;

std::string node_text(dronecan::NodeId node) {
    return node == dronecan::kNobody ? "anon" : fmt::format("{}", node);
}

std::string sender_text(dronecan::NodeId node) {
    return node == dronecan::kNobody ? "anonymous" : fmt::format("node {}", node);
}

std::string nodes_text(const dronecan::TransferHead& head) {
    return head.kind == TransferKind::message
               ? node_text(head.source)
               : fmt::format("{}->{}", head.source, head.destination);
}

std::string named(TransferKind kind, std::uint16_t data_type_id) {
    const std::string type = type_text(kind, data_type_id);
    return kind == TransferKind::message ? type : fmt::format("{} {}", type, kind_name(kind));
}

std::string payload_text(const ExplainedTransfer& transfer) {
    return transfer.payload.empty() ? "no payload"
                                    : fmt::format("{:02x}", fmt::join(transfer.payload, " "));
}

std::string frames_text(std::size_t frames) {
    return fmt::format("{} {} received", frames, frames == 1 ? "frame" : "frames");
}

bool is_failsafe(const ExplainedTransfer& transfer) {
    return rc_input_of(transfer) && rc_input_of(transfer)->failsafe;
}

std::string content_text(const ExplainedTransfer& transfer) {
    if (transfer.fault != TransferFault::none) {
        return fmt::format("  broken: {} ({}): {}",
                           kFaultTexts.at(static_cast<std::size_t>(transfer.fault)),
                           frames_text(transfer.frames), payload_text(transfer));
    }
    if (transfer.type == nullptr) {
        return fmt::format("  unknown{}: {}", transfer.crc_unchecked ? ", CRC not checked" : "",
                           payload_text(transfer));
    }
    const std::string fields = fields_text(fields_of(transfer));
    return (fields.empty() ? "" : "  " + fields) + (is_failsafe(transfer) ? "  failsafe" : "");
}

/// Breaks a line between words; a word longer than a line is not broken.
std::string broken_into(std::string_view line, std::size_t columns) {
    const bool roomy = columns >= kIndent + kLeastText;
    const std::string indent(roomy ? kIndent : kNarrowIndent, ' ');
    std::string text;
    std::size_t room = columns;
    while (line.size() > room) {
        const std::size_t first_word = line.find_first_not_of(' ');
        std::size_t end = line.rfind(' ', room);
        if (end == std::string_view::npos || end < first_word) {
            end = line.find(' ', std::max(room, first_word));
        }
        if (end == std::string_view::npos) {
            break;
        }
        text += line.substr(0, end);
        text.erase(text.find_last_not_of(' ') + 1);
        text += '\n' + indent;
        line.remove_prefix(std::min(line.find_first_not_of(' ', end), line.size()));
        room = columns > indent.size() ? columns - indent.size() : 1;
    }
    return text.append(line);
}

/// ` 3 bad_crc, 1 broke_off`; empty if no transfer was rejected.
std::string rejected_text(const TransferCounts& counts) {
    std::string text;
    for (std::size_t fault = 1; fault < counts.size(); ++fault) {
        if (counts.at(fault) > 0) {
            text += fmt::format("{} {} {}", text.empty() ? "" : ",", counts.at(fault),
                                kTransferFaultNames.at(fault));
        }
    }
    return text;
}

std::string in_csv_quotes(std::string_view text) {
    std::string quoted = "\"";
    for (const char each : text) {
        quoted += each == '"' ? "\"\"" : std::string(1, each);
    }
    return quoted + '"';
}

}  // namespace

std::string type_text(TransferKind kind, std::uint16_t data_type_id) {
    const auto* const known = dronecan::find_known_payload(kind, data_type_id);
    if (known != nullptr) {
        return std::string(known->type.name);
    }
    return fmt::format("{} {}", kind == TransferKind::message ? "message type" : "service",
                       data_type_id);
}

std::string_view kind_name(TransferKind kind) {
    constexpr std::array<std::string_view, 3> kNames{"message", "request", "response"};
    return kNames.at(static_cast<std::size_t>(kind));
}

void append_transfer_text_heading(std::string& text) {
    text += fmt::format("{:>12} {:>8} {:>4} {:>3}  {}\n", "t_us", "node", "prio", "id", "transfer");
}

void append_transfer_text(std::string& text, const ExplainedTransfer& transfer,
                          std::optional<std::size_t> columns) {
    const dronecan::TransferHead& head = transfer.head;
    const std::string after =
        transfer.answered_after
            ? fmt::format(" after {} us", whole_microseconds(*transfer.answered_after))
            : "";
    const std::string line =
        fmt::format("{:>12} {:>8} {:>4} {:>3}  {}{}{}", whole_microseconds(transfer.last_at),
                    nodes_text(head), head.priority, head.transfer_id,
                    named(head.kind, head.data_type_id), after, content_text(transfer));
    text += columns ? broken_into(line, *columns) : line;
    text += '\n';
}

void append_transfer_summary_text(std::string& text, const TransferTally& tally) {
    const std::string rejected = rejected_text(tally.counts);
    text += fmt::format("{} in {} of {}, {}, {}, {}, rejected:{}; 0 is {} of the log\n",
                        counted(tally.counts.front(), "transfer"),
                        counted(tally.can_frames, "CAN frame"), counted(tally.bytes, "byte"),
                        counted(tally.other_can_frames, "other CAN frame"),
                        counted(tally.log.error_frames, "error frame"),
                        counted(tally.repeated_frames, "repeated frame"),
                        rejected.empty() ? " none" : rejected, log_time_text(tally.log.start));
    if (tally.requests + tally.responses > 0) {
        text += fmt::format("{}, {}, {} without one\n", counted(tally.requests, "request"),
                            counted(tally.responses, "response"),
                            counted(tally.requests - tally.answered, "request"));
    }
    for (const auto& [stream, counts] : tally.streams) {
        const std::string broken = rejected_text(counts);
        text += fmt::format(
            "{}: {}, {}{}{}\n", sender_text(stream.source), named(stream.kind, stream.data_type_id),
            counted(counts.front(), "transfer"), broken.empty() ? "" : ", rejected:", broken);
    }
}

void append_transfer_csv_heading(std::string& text) {
    text +=
        "t_us,kind,type,type_id,source,destination,priority,transfer_id,frames,broken,response_us,"
        "payload,fields\n";
}

void append_transfer_csv(std::string& text, const ExplainedTransfer& transfer) {
    const dronecan::TransferHead& head = transfer.head;
    const auto number = [](bool there, auto value) {
        return there ? fmt::format("{}", value) : std::string();
    };
    const bool broken = transfer.fault != TransferFault::none;
    text += fmt::format(
        "{},{},{},{},{},{},{},{},{},{},{},{},{}\n", whole_microseconds(transfer.last_at),
        kind_name(head.kind), transfer.type == nullptr ? "" : transfer.type->type.name,
        head.data_type_id, number(head.source != dronecan::kNobody, head.source),
        number(head.kind != TransferKind::message, head.destination), head.priority,
        head.transfer_id, transfer.frames,
        broken ? kTransferFaultNames.at(static_cast<std::size_t>(transfer.fault)) : "",
        transfer.answered_after ? fmt::format("{}", whole_microseconds(*transfer.answered_after))
                                : "",
        fmt::format("{:02x}", fmt::join(transfer.payload, "")),
        in_csv_quotes(fields_text(fields_of(transfer))));
}

}  // namespace tribus
