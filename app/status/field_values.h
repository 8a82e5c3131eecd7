#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "app/status/fields.h"
#include "app/status/status.h"
#include "config/schema/choices.h"
#include "config/show/fields_json.h"

/// Values of a status as JSON. Pure.
namespace tribus::field_values {

using OrderedJson = nlohmann::ordered_json;

inline std::int64_t us(Duration duration) {
    return std::chrono::duration_cast<std::chrono::microseconds>(duration).count();
}

/// Null for an instant that was never set.
inline OrderedJson age(Instant at, Instant now) {
    return at == Instant{} ? OrderedJson() : OrderedJson(std::max<std::int64_t>(us(now - at), 0));
}

/// JSON has neither infinity nor "not a number".
inline OrderedJson finite(double number) {
    return std::isfinite(number) ? number_json(number) : OrderedJson();
}

/// Null for an empty text.
inline OrderedJson text_or_null(std::string_view text) {
    return text.empty() ? OrderedJson() : OrderedJson(text);
}

/// The words of an enumeration, in the order of its values; an empty one is null.
template <std::size_t Count, class Choice>
OrderedJson word_in(const std::array<std::string_view, Count>& words, Choice choice) {
    return text_or_null(words[static_cast<std::size_t>(choice)]);
}

/// The names of the parts with these indices.
template <class Config>
OrderedJson names_of(std::span<const std::size_t> indices, const std::vector<Config>& parts) {
    OrderedJson json = OrderedJson::array();
    for (const std::size_t index : indices) {
        json.push_back(parts[index].name);
    }
    return json;
}

inline OrderedJson json_of(Duration duration) {
    return us(duration);
}
inline OrderedJson json_of(double number) {
    return number_json(number);
}
inline OrderedJson json_of(const PortConfig& port) {
    return port.device;
}
inline OrderedJson json_of(const Protocol* protocol) {
    return protocol->name;
}
/// Up to the last channel that is there.
OrderedJson json_of(const ChannelFrame& frame);
OrderedJson json_of(const HistogramReading& reading);
template <class Value>
concept JsonValue = std::constructible_from<OrderedJson, const Value&>;
template <JsonValue Value>
OrderedJson json_of(const Value& value) {
    return value;
}
template <class Value>
OrderedJson json_of(const std::optional<Value>& value) {
    return value ? json_of(*value) : OrderedJson();
}

// Each finds a struct of a part by its type, for `member`.

inline const InputConfig& of(const StatusPart& part, const InputConfig*) {
    return part.report.configuration->inputs[part.index];
}
inline const InputReport& of(const StatusPart& part, const InputReport*) {
    return part.report.inputs[part.index];
}
inline const InputFigures& of(const StatusPart& part, const InputFigures*) {
    return part.report.inputs[part.index].status;
}
inline const InputCounts& of(const StatusPart& part, const InputCounts*) {
    return part.report.inputs[part.index].status.counts;
}
inline const OutputConfig& of(const StatusPart& part, const OutputConfig*) {
    return part.report.configuration->outputs[part.index];
}
inline const OutputReport& of(const StatusPart& part, const OutputReport*) {
    return part.report.outputs[part.index];
}
inline const OutputFigures& of(const StatusPart& part, const OutputFigures*) {
    return part.report.outputs[part.index].status;
}
inline const OutputState& of(const StatusPart& part, const OutputState*) {
    return part.report.outputs[part.index].status.state;
}
inline const OutputCounts& of(const StatusPart& part, const OutputCounts*) {
    return part.report.outputs[part.index].status.counts;
}
inline const PipelineConfig& of(const StatusPart& part, const PipelineConfig*) {
    return part.report.configuration->pipelines[part.index];
}
inline const PortReport& of(const StatusPart& part, const PortReport*) {
    return part.report.ports[part.index];
}
inline const CanCounts& of(const StatusPart& part, const CanCounts*) {
    return part.report.ports[part.index].can->counts;
}
inline const LineConfig& of(const StatusPart& part, const LineConfig*) {
    return part.report.configuration->lines[part.index];
}
inline const LineReport& of(const StatusPart& part, const LineReport*) {
    return part.report.lines[part.index];
}
inline const SensorBusConfig& of(const StatusPart& part, const SensorBusConfig*) {
    return part.report.configuration->sensor_buses[part.index];
}
inline const SensorBusState& of(const StatusPart& part, const SensorBusState*) {
    return part.report.sensor_buses[part.index];
}
inline const NodeStatus& of(const StatusPart& part, const NodeStatus*) {
    return part.report.nodes[part.index];
}
inline const dronecan::NodeCounts& of(const StatusPart& part, const dronecan::NodeCounts*) {
    return part.report.nodes[part.index].report.counts;
}
inline const ValueReport& of(const StatusPart& part, const ValueReport*) {
    return part.report.values[part.index];
}
inline const NamedValue& of(const StatusPart& part, const NamedValue*) {
    return part.report.values[part.index].value;
}
inline const StatusReport& of(const StatusPart& part, const StatusReport*) {
    return part.report;
}

/// That struct of a part.
template <class Owner>
const Owner& of(const StatusPart& part) {
    return of(part, static_cast<const Owner*>(nullptr));
}

template <class Owner, class Value>
OrderedJson member_of(const StatusPart& part, Value Owner::*member) {
    return json_of(of<Owner>(part).*member);
}
/// Reads a member, for a row.
template <auto Member>
OrderedJson member(const StatusPart& part) {
    return member_of(part, Member);
}

}  // namespace tribus::field_values
