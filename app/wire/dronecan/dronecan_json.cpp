#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstddef>
#include <nlohmann/json.hpp>

#include "app/wire/dronecan/dronecan_fields.h"
#include "app/wire/dronecan/dronecan_text.h"
#include "app/wire/frames/frame_json.h"

namespace tribus {
namespace {

using dronecan::TransferKind;
using OrderedJson = nlohmann::ordered_json;

void add_channels(OrderedJson& object, const RcInputChannels& input) {
    OrderedJson channels = OrderedJson::array();
    for (const auto& channel : input.channels) {
        channels.push_back(channel ? OrderedJson(*channel) : OrderedJson());
    }
    object["channels"] = std::move(channels);
    object["frame_lost"] = false;
    object["failsafe"] = input.failsafe;
}

OrderedJson node_json(bool there, dronecan::NodeId node) {
    return there ? OrderedJson(node) : OrderedJson();
}

void add_head(OrderedJson& object, const ExplainedTransfer& transfer) {
    const dronecan::TransferHead& head = transfer.head;
    object["kind"] = kind_name(head.kind);
    object["type"] =
        transfer.type == nullptr ? OrderedJson() : OrderedJson(transfer.type->type.name);
    object["type_id"] = head.data_type_id;
    object["source"] = node_json(head.source != dronecan::kNobody, head.source);
    object["destination"] = node_json(head.kind != TransferKind::message, head.destination);
    object["priority"] = head.priority;
    object["transfer_id"] = head.transfer_id;
    object["fd"] = transfer.fd;
    object["frames"] = transfer.frames;
    if (transfer.first_at != transfer.last_at) {
        object["first_us"] = whole_microseconds(transfer.first_at);
    }
}

OrderedJson rejected_json(const TransferCounts& counts, bool all) {
    OrderedJson rejected = OrderedJson::object();
    for (std::size_t fault = 1; fault < counts.size(); ++fault) {
        if (all || counts.at(fault) > 0) {
            rejected[std::string(kTransferFaultNames.at(fault))] = counts.at(fault);
        }
    }
    return rejected;
}

OrderedJson stream_json(const TransferStream& stream, const TransferCounts& counts) {
    const auto* const known = dronecan::find_known_payload(stream.kind, stream.data_type_id);
    return {{"kind", kind_name(stream.kind)},
            {"type", known == nullptr ? OrderedJson() : OrderedJson(known->type.name)},
            {"type_id", stream.data_type_id},
            {"source", node_json(stream.source != dronecan::kNobody, stream.source)},
            {"transfers", counts.front()},
            {"rejected", rejected_json(counts, false)}};
}

}  // namespace

void append_transfer_json(std::string& text, const ExplainedTransfer& transfer) {
    OrderedJson object = OrderedJson::object();
    object["t_us"] = whole_microseconds(transfer.last_at);
    object["protocol"] = "dronecan";
    if (const auto input = rc_input_of(transfer)) {
        add_channels(object, *input);
    }
    add_head(object, transfer);
    if (transfer.answered_after) {
        object["response_us"] = whole_microseconds(*transfer.answered_after);
    }
    if (transfer.fault != TransferFault::none) {
        object["broken"] = kTransferFaultNames.at(static_cast<std::size_t>(transfer.fault));
    } else if (transfer.type != nullptr) {
        ExplainedFields fields = fields_of(transfer);
        object["fields"] = std::move(fields.values);
        if (!fields.units.empty()) {
            object["units"] = std::move(fields.units);
        }
    } else {
        object["crc_checked"] = !transfer.crc_unchecked;
    }
    object["payload"] = fmt::format("{:02x}", fmt::join(transfer.payload, ""));
    text += plain_json(object);
    text += '\n';
}

void append_transfer_summary_json(std::string& text, const TransferTally& tally,
                                  std::string_view input) {
    OrderedJson streams = OrderedJson::array();
    for (const auto& [stream, counts] : tally.streams) {
        streams.push_back(stream_json(stream, counts));
    }
    const OrderedJson summary{{"bytes", tally.bytes},
                              {"can_frames", tally.can_frames},
                              {"frames", tally.counts.front()},
                              {"rejected", rejected_json(tally.counts, true)},
                              {"other_can_frames", tally.other_can_frames},
                              {"repeated_frames", tally.repeated_frames},
                              {"requests", tally.requests},
                              {"responses", tally.responses},
                              {"unanswered", tally.requests - tally.answered},
                              {"transfers", std::move(streams)},
                              {"error_frames", tally.log.error_frames},
                              {"log_start_us", whole_microseconds(tally.log.start)},
                              {"input", input}};
    text += plain_json({{"summary", summary}});
    text += '\n';
}

}  // namespace tribus
