#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/time.h"

/// Statuses and events of a daemon for MQTT, made of its statuses (docs/status.md). Pure.
namespace tribus::mqtt {

using Json = nlohmann::json;

/// Figures that the data thread published longer ago than this are not told.
inline constexpr Duration kOldFigures = std::chrono::seconds(1);

/// A change, told once.
struct Event {
    std::string type{};             ///< part of the change
    std::string name{};             ///< of the input, output, ...
    std::string now{};              ///< a word of the status: a cause, a state
    std::string before{};           ///< the same; empty if unknown
    std::string text{};             ///< for people
    std::int64_t unix_time_us = 0;  ///< by the clock of the board
    Instant at{};
};

/// Words of `Event::type`.
std::vector<std::string_view> event_types();

/// The event of a change that the daemon tells (docs/status.md, "Changes"); `status` is of `now`.
/// Nothing for details of a state.
std::optional<Event> event_of(const Json& change, const Json& status, Instant now);

/// An event about the daemon itself.
Event daemon_event(std::string_view word, std::string_view text, std::int64_t unix_time_us,
                   Instant at);

/// Whether the figures of the status are new enough to be told.
bool has_new_figures(const Json& status);

/// The payload of the topic "status": one JSON object. Old figures and stale numbers are left out.
std::string status_payload(const Json& status);

/// Whether a value of the status is told: it has come once, and is not one that tribus makes of
/// its inputs and outputs, which are told anyway.
bool is_told(const Json& value);

/// The payload of the topic "event": one JSON object. `id`: unique. `late`: it could not be told
/// when it happened. `lost_before`: so many events before it were never told.
std::string event_payload(const Event& event, std::string_view id, bool late,
                          std::uint64_t lost_before, Instant now);

/// The name with letters, digits and the characters of `kept` as they are; each other byte becomes
/// `mark` and two hexadecimal digits, so different names stay different. `kept` must not have
/// `mark`.
std::string escaped(std::string_view name, char mark, std::string_view kept);

/// A level of a topic for that name, and for no other one: `escaped` with `%`; `-`, `.` and `_`
/// stay.
std::string topic_level(std::string_view name);

/// Whether topics may begin with the text: levels with 1 to 64 characters of ASCII together, none
/// of which has a meaning for a broker.
bool may_begin_topics(std::string_view text);

}  // namespace tribus::mqtt
