#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace tribus {

/// The kinds of stations. `Stations` knows what each of them does.
enum class StationKind : std::uint8_t {
    input,
    output,
    dronecan_node,
    sensor_bus,
    value_message,  ///< reads named values from messages
    replies,        ///< hears for an output what comes back on its line; the index is the output's
    answers,        ///< sends for an input what it answers; the index is the input's
};
inline constexpr std::size_t kStationKinds = 7;

/// One part of a configuration that sits on a port. A serial device may have an input and an
/// output, a CAN interface many of each.
struct Station {
    StationKind kind = StationKind::input;
    std::size_t index = 0;  ///< among the parts of its kind, in the order of the configuration

    bool operator==(const Station&) const = default;
};

constexpr Station input_station(std::size_t index) {
    return {.kind = StationKind::input, .index = index};
}

/// Index of the first station of that kind on a port. `nullopt` if there is none.
constexpr std::optional<std::size_t> first_of(std::span<const Station> stations, StationKind kind) {
    const auto found = std::ranges::find(stations, kind, &Station::kind);
    return found == stations.end() ? std::nullopt : std::optional(found->index);
}

/// Whether one of them reads bytes.
constexpr bool wants_bytes(std::span<const Station> stations) {
    return std::ranges::any_of(stations, [](const Station& station) {
        return station.kind == StationKind::input || station.kind == StationKind::sensor_bus ||
               station.kind == StationKind::value_message || station.kind == StationKind::replies;
    });
}

/// Whether it may have something to send.
constexpr bool sends(const Station& station) {
    return station.kind == StationKind::output || station.kind == StationKind::dronecan_node ||
           station.kind == StationKind::sensor_bus || station.kind == StationKind::answers;
}

}  // namespace tribus
