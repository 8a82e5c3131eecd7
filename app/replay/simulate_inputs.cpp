#include "app/replay/simulate_inputs.h"

#include <algorithm>
#include <optional>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "app/cli/streams.h"
#include "config/schema/value_catalog.h"
#include "core/quotes.h"
#include "transports/codecs/ibus_sensor/ibus_sensor.h"
#include "transports/recordings/candump.h"
#include "transports/recordings/recording.h"

namespace tribus {
namespace {

bool is_empty(const Recording& recording) {
    return recording.bursts.empty() && recording.can_frames.empty();
}

/// Name in messages.
std::string title_of(const SimulatedSource& source) {
    const std::string name = in_quotes(source.name);
    return source.station.kind == StationKind::input ? "input " + name
           : source.station.kind == StationKind::sensor_bus
               ? "sensor bus " + name
               : fmt::format("[values.{}]", source.name);
}

/// The recording, if it fits the source's kind of link. An empty one fits both.
tl::expected<Recording, std::string> load_recording(const std::string& path,
                                                    const SimulatedSource& source) {
    auto file = InputFile::open_path(path);
    if (!file) {
        return tl::unexpected(std::move(file.error()));
    }
    const auto content = file->read_all();
    if (!content) {
        return tl::unexpected(content.error());
    }
    const auto kind = detect_recording_kind(*content, path);
    const bool log = kind == RecordingKind::candump;
    auto recording = parse_recording(*content, path);
    const bool empty = recording && is_empty(*recording);
    if (source.port->medium->shape == WireShape::can_frames && !log && !empty) {
        return tl::unexpected(fmt::format(
            "{}: this is not a log of CAN frames, but {} has the protocol {}; it takes lines such "
            "as (1436509052.249713) can0 123#1122, as candump -L writes them",
            path, title_of(source), source.protocol));
    }
    if (source.port->medium->shape == WireShape::bytes && log) {
        return tl::unexpected(fmt::format(
            "{}: this is a log of CAN frames, but {} has the protocol {}; it takes recorded "
            "bytes: raw, hex, timed hex or the CSV of a Saleae serial decoder",
            path, title_of(source), source.protocol));
    }
    return recording;
}

/// Bursts without times are played at the protocol's usual period.
void add_bytes(Arrivals& arrivals, const Recording& recording, std::size_t index,
               const SimulatedSource& source) {
    Duration untimed{};
    for (const Burst& burst : recording.bursts) {
        const Duration start = burst.start.value_or(untimed);
        for (std::size_t i = 0; i < burst.bytes.size(); ++i) {
            arrivals.in_order.push_back(
                {Instant(start + source.port->line.bytes_time(i + 1)), index,
                 ArrivedByte{burst.bytes[i], burst.damaged[i], !burst.start.has_value()}});
        }
        untimed +=
            std::max(source.usual_period, source.port->line.bytes_time(burst.bytes.size() + 1));
    }
}

tl::expected<void, std::string> add_can_frames(Arrivals& arrivals, const Recording& recording,
                                               std::size_t index, const SimulatedSource& source,
                                               std::string_view path) {
    const std::vector<std::string> names = interfaces_in(recording);
    const std::string& own = source.port->device;
    const bool has_own = std::find(names.begin(), names.end(), own) != names.end();
    if (!has_own && names.size() > 1) {
        const std::vector<std::string_view> views(names.begin(), names.end());
        return tl::unexpected(fmt::format(
            "{}: has frames of {}, but none of {}, the interface of {}; set one of them there",
            path, in_quotes_all(views), in_quotes(own), title_of(source)));
    }
    for (const RecordedCanFrame& recorded : recording.can_frames) {
        if (!has_own || recorded.interface == own) {
            arrivals.in_order.push_back(
                {Instant(recorded.at), index, ArrivedCanFrame{arrivals.can_frames.size()}});
            arrivals.can_frames.push_back(recorded.frame);
        }
    }
    return {};
}

}  // namespace

std::vector<SimulatedSource> simulated_sources(const Configuration& configuration) {
    std::vector<SimulatedSource> sources;
    for (std::size_t i = 0; i < configuration.inputs.size(); ++i) {
        const InputConfig& input = configuration.inputs[i];
        sources.push_back({.station = {.kind = StationKind::input, .index = i},
                           .name = input.name,
                           .protocol = input.protocol->name,
                           .port = &input.port,
                           .usual_period = input.protocol->default_period});
    }
    if (!needs_values(configuration)) {
        return sources;
    }
    for (std::size_t i = 0; i < configuration.sensor_buses.size(); ++i) {
        const SensorBusConfig& bus = configuration.sensor_buses[i];
        sources.push_back({.station = {.kind = StationKind::sensor_bus, .index = i},
                           .name = bus.name,
                           .protocol = kSensorBusName,
                           .port = &bus.port,
                           .usual_period = kUsualSlot});
    }
    std::size_t message = 0;
    for (const ValuesConfig& values : configuration.values) {
        if (const auto* source = std::get_if<ValueMessageConfig>(&values.source)) {
            sources.push_back({.station = {.kind = StationKind::value_message, .index = message++},
                               .name = values.name,
                               .protocol = std::holds_alternative<DbcValueSource>(source->layout)
                                               ? "dbc"
                                               : "dronecan",
                               .port = &source->port});
        }
    }
    return sources;
}

tl::expected<Arrivals, std::string> load_arrivals(const std::map<std::size_t, std::string>& files,
                                                  std::span<const SimulatedSource> sources) {
    Arrivals arrivals;
    for (const auto& [index, path] : files) {
        const SimulatedSource& source = sources[index];
        const auto recording = load_recording(path, source);
        if (!recording) {
            return tl::unexpected(recording.error());
        }
        add_bytes(arrivals, *recording, index, source);
        const auto added = add_can_frames(arrivals, *recording, index, source, path);
        if (!added) {
            return tl::unexpected(added.error());
        }
    }
    std::stable_sort(arrivals.in_order.begin(), arrivals.in_order.end(),
                     [](const Arrival& a, const Arrival& b) { return a.at < b.at; });
    return arrivals;
}

}  // namespace tribus
