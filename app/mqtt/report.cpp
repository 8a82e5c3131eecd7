#include "app/mqtt/report.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <ctime>
#include <optional>
#include <span>

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/client/status_fields.h"
#include "app/status/fields.h"
#include "app/status/status.h"

namespace tribus::mqtt {
namespace {

using namespace status_fields;
using OrderedJson = nlohmann::ordered_json;

constexpr std::int64_t kMicrosecondsASecond = 1'000'000;
constexpr std::array<std::string_view, 8> kEventTypes{"input", "output", "device",        "bus",
                                                      "node",  "value",  "configuration", "daemon"};

/// "2026-11-26T20:45:13.250Z".
std::string utc(std::int64_t unix_time_us) {
    constexpr std::int64_t kMicrosecondsAMillisecond = 1000;
    const auto seconds = static_cast<std::time_t>(unix_time_us / kMicrosecondsASecond);
    std::tm time{};
    ::gmtime_r(&seconds, &time);
    return fmt::format("{:%FT%T}.{:03}Z", time,
                       unix_time_us % kMicrosecondsASecond / kMicrosecondsAMillisecond);
}

/// Seconds, to the millisecond; null if the field is missing.
OrderedJson seconds_of(const Json& object, const char* key) {
    constexpr double kMillisecondsASecond = 1000;
    const auto microseconds = number(object, key);
    return microseconds ? OrderedJson(std::round(*microseconds / kMillisecondsASecond) /
                                      kMillisecondsASecond)
                        : OrderedJson();
}

OrderedJson text_or_null(const Json& object, const char* key) {
    const std::string value = raw_text(object, key);
    return value.empty() ? OrderedJson() : OrderedJson(value);
}

OrderedJson number_or_null(const Json& object, const char* key) {
    const auto value = number(object, key);
    return value ? OrderedJson(*value) : OrderedJson();
}

OrderedJson value_of(const StatusField& row, const Json& object) {
    const std::string key(row.name);
    const bool in_seconds = row.kind == FieldKind::time && row.options.fleet.ends_with("_s");
    switch (row.kind) {
        case FieldKind::text:
        case FieldKind::word:
            return text_or_null(object, key.c_str());
        case FieldKind::flag:
            return flag(object, key.c_str());
        case FieldKind::time:
            return in_seconds ? seconds_of(object, key.c_str())
                              : OrderedJson(whole(object, key.c_str()).value_or(0));
        default:
            return number_or_null(object, key.c_str());
    }
}

void tell(std::span<const StatusField> rows, const Json& object, OrderedJson& told) {
    for (const StatusField& row : rows) {
        if (!row.options.fleet.empty()) {
            told[std::string(row.options.fleet)] = value_of(row, object);
        }
    }
}

OrderedJson parts_json(const PartKind& kind, const Json& status) {
    OrderedJson json = OrderedJson::object();
    for (const Json& part : list(status, std::string(kind.list).c_str())) {
        if (kind.list == "values" && !is_told(part)) {
            continue;
        }
        OrderedJson& told = json[raw_text(part, "name")];
        told = OrderedJson::object();
        tell(kind.fields, part, told);
        if (const Json& can = field(part, "can"); can.is_object()) {
            tell(can_kind().fields, can, told);
        }
        // A daemon of an earlier version does not say whether an input is good.
        if (kind.list == "inputs") {
            told["good"] = raw_text(part, "cause") == "good";
        }
        // An old number is none.
        if (flag(part, "stale")) {
            told["number"] = nullptr;
        }
    }
    return json;
}

std::string one_line(const OrderedJson& json) {
    // Names of devices may have bytes that are not UTF-8.
    return json.dump(-1, ' ', false, OrderedJson::error_handler_t::replace);
}

}  // namespace

std::vector<std::string_view> event_types() {
    return {kEventTypes.begin(), kEventTypes.end()};
}

std::optional<Event> event_of(const Json& change, const Json& status, Instant now) {
    const std::string part = raw_text(change, "part");
    const std::string what = raw_text(change, "field");
    const bool known = std::ranges::find(kEventTypes, part) != kEventTypes.end();
    const bool of_state = what == "state" || what == "cause" || what == "lost";
    if (!known || (!of_state && what != "input")) {
        return std::nullopt;
    }
    const std::int64_t ago_us =
        whole(status, "t_us").value_or(0) - whole(change, "t_us").value_or(0);
    Event event{.type = part,
                .name = raw_text(change, "name"),
                .now = raw_text(change, "now"),
                .before = raw_text(change, "was"),
                .text = raw_text(change, "text"),
                .unix_time_us = whole(change, "unix_time_us").value_or(0),
                .at = now - std::chrono::microseconds(ago_us)};
    if (!of_state) {
        // Another input has taken over, in the same state.
        event.now = "control";
        event.before = "control";
    }
    return event;
}

Event daemon_event(std::string_view word, std::string_view text, std::int64_t unix_time_us,
                   Instant at) {
    return {.type = "daemon",
            .name = {},
            .now = std::string(word),
            .before = {},
            .text = std::string(text),
            .unix_time_us = unix_time_us,
            .at = at};
}

bool has_new_figures(const Json& status) {
    const auto age = whole(status, "figures_age_us");
    return age && std::chrono::microseconds(*age) <= kOldFigures;
}

bool is_told(const Json& value) {
    return number(value, "age_us") && !is_of_part(raw_text(value, "name"));
}

std::string status_payload(const Json& status) {
    OrderedJson json{{"time", utc(whole(status, "unix_time_us").value_or(0))}};
    tell(program_fields(), status, json);
    const bool tells_parts = has_new_figures(status);
    for (const PartKind& kind : part_kinds()) {
        if (!kind.fleet.empty()) {
            json[std::string(kind.fleet)] =
                tells_parts ? parts_json(kind, status) : OrderedJson::object();
        }
    }
    return one_line(json);
}

std::string event_payload(const Event& event, std::string_view id, bool late,
                          std::uint64_t lost_before, Instant now) {
    constexpr double kMillisecondsASecond = 1000;
    const auto age = std::chrono::duration_cast<std::chrono::milliseconds>(now - event.at);
    OrderedJson json{{"event_type", event.type},
                     {"id", id},
                     {"name", event.name},
                     {"now", event.now},
                     {"before", event.before.empty() ? OrderedJson() : OrderedJson(event.before)},
                     {"text", event.text},
                     {"time", utc(event.unix_time_us)},
                     {"unix_time_us", event.unix_time_us},
                     {"age_s", static_cast<double>(age.count()) / kMillisecondsASecond},
                     {"late", late}};
    if (lost_before > 0) {
        json["lost_before"] = lost_before;
    }
    return one_line(json);
}

std::string escaped(std::string_view name, char mark, std::string_view kept) {
    std::string text;
    for (const char c : name) {
        const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                           (c >= '0' && c <= '9') || kept.find(c) != std::string_view::npos;
        text += plain ? std::string(1, c)
                      : fmt::format("{}{:02X}", mark, static_cast<unsigned char>(c));
    }
    return text;
}

std::string topic_level(std::string_view name) {
    // No other name is written so.
    return name.empty() ? "%" : escaped(name, '%', "-._");
}

bool may_begin_topics(std::string_view text) {
    // MQTT 5.0, 4.7: wildcards; topics that begin with $ are the broker's.
    constexpr std::size_t kLongest = 64;
    return text.size() <= kLongest && !text.empty() && !text.starts_with('$') &&
           !text.starts_with('/') && !text.ends_with('/') &&
           text.find("//") == std::string_view::npos &&
           std::ranges::all_of(
               text, [](unsigned char c) { return c > ' ' && c < 0x7F && c != '+' && c != '#'; });
}

}  // namespace tribus::mqtt
