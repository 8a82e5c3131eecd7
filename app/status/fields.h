#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

/// The fields of a status: each kind of part has one row for each field. The rows make the status
/// in JSON, metrics, MQTT, the tables of docs/status.md and docs/fleet.md, and the types of the
/// page.
namespace tribus {

struct StatusReport;

/// The content of a field. It decides how the field is written.
enum class FieldKind : std::uint8_t {
    text,
    word,          ///< one of `FieldOptions::words`
    flag,          ///< true or false
    amount,        ///< a number
    counter,       ///< since the program started
    counters,      ///< a counter for each of some words
    time,          ///< in microseconds
    distribution,  ///< of times: `count`, `p50_us`, `p99_us`, `max_us`
    channels,      ///< pulses in microseconds, null for an absent channel
    other,         ///< see `FieldOptions::shape`
};

/// One part of a report, by its place in the list of its kind.
struct StatusPart {
    const StatusReport& report;
    std::size_t index;
};

/// Facts that only some fields have.
struct FieldOptions {
    bool may_be_null = false;
    /// Some parts do not have it.
    bool optional = false;
    /// All words that it may be.
    std::span<const std::string_view> words{};
    /// Its type in the page, if its kind does not say it.
    std::string_view shape{};
    /// Its name among the metrics, behind the word of its part. Empty: none, but a counter has its
    /// own name with "_total".
    std::string_view metric{};
    /// The label that tells the words of `counters` apart.
    std::string_view metric_label = "cause";
    /// Its name in the payload of MQTT, where times are in seconds. Empty: it is not told.
    std::string_view fleet{};
    /// False: it follows from other fields of the status, and only metrics tell it.
    bool in_status = true;
};

struct StatusField {
    std::string_view name;
    FieldKind kind;
    /// For people, in Markdown, without a full stop.
    std::string_view help;
    /// Null: it is not known, or there is none. Discarded: such a part has no such field.
    nlohmann::ordered_json (*read)(const StatusPart&);
    FieldOptions options{};
};

/// Parts that have the same fields.
struct PartKind {
    std::string_view list;   ///< the member of a status that lists them; empty: "can", in a port
    std::string_view word;   ///< begins the names of its metrics
    std::string_view label;  ///< of its metrics, with the part's name
    std::string_view fleet;  ///< lists them in the payload of MQTT; empty: none tells them there
    std::span<const StatusField> fields;
    std::size_t (*count)(const StatusReport&);
    /// Empty: the part is none of this kind, as a serial port is no CAN interface.
    std::string_view (*name)(const StatusPart&);
};

/// Fields of the daemon itself; the index of the part has no meaning.
std::span<const StatusField> program_fields();
/// In the order of a status.
std::span<const PartKind> part_kinds();
/// The fields of a CAN interface, which its port has besides its own.
const PartKind& can_kind();

/// The fields that a status tells of a part.
nlohmann::ordered_json fields_json(std::span<const StatusField> fields, const StatusPart& part);
/// The name of a field's metric, without "tribus_" and the word of its part. Empty: it has none.
std::string metric_of(const StatusField& field);
/// The type of a field's metric: "counter", "summary" or "gauge".
std::string_view metric_type(const StatusField& field);
/// A help without its marks of Markdown.
std::string plain_text(std::string_view help);

}  // namespace tribus
