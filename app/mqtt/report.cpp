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

namespace tribus::mqtt {
namespace {

using namespace status_fields;
using OrderedJson = nlohmann::ordered_json;

constexpr std::int64_t kMicrosecondsASecond = 1'000'000;
constexpr std::array<std::string_view, 7> kEventTypes{"input", "output",        "device", "bus",
                                                      "value", "configuration", "daemon"};

std::string with_blanks(std::string word) {
    std::ranges::replace(word, '_', ' ');
    return word;
}

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

const Json* named(const Json& elements, const std::string& name) {
    const auto found = std::ranges::find_if(
        elements, [&name](const Json& element) { return raw_text(element, "name") == name; });
    return found == elements.end() ? nullptr : &*found;
}

/// Collects the changes between two statuses.
class Changes {
  public:
    Changes(const Json& before, const Json& after, Instant now)
        : before_(before), after_(after), now_(now) {}

    std::vector<Event> take() {
        if (number(after_, "uptime_us").value_or(0) < number(before_, "uptime_us").value_or(0)) {
            // Counters and states of another process say nothing of changes.
            add({"daemon", raw_text(after_, "name"), "restarted", "", "started again"},
                whole(after_, "uptime_us"));
            return std::move(events_);
        }
        configuration();
        each("inputs", [this](const Json& old, const Json& fresh) { input(old, fresh); });
        each("outputs", [this](const Json& old, const Json& fresh) { output(old, fresh); });
        each("ports", [this](const Json& old, const Json& fresh) { port(old, fresh); });
        each("values", [this](const Json& old, const Json& fresh) { value(old, fresh); });
        return std::move(events_);
    }

  private:
    /// `ago_us`: for how long it has been so.
    void add(Event event, std::optional<std::int64_t> ago_us = std::nullopt) {
        const std::int64_t ago = ago_us.value_or(0);
        event.unix_time_us = whole(after_, "unix_time_us").value_or(0) - ago;
        event.at = now_ - std::chrono::microseconds(ago);
        events_.push_back(std::move(event));
    }

    template <class Compare>
    void each(const char* key, Compare compare) {
        for (const Json& fresh : list(after_, key)) {
            if (const Json* old = named(list(before_, key), raw_text(fresh, "name"))) {
                compare(*old, fresh);
            }
        }
    }

    void configuration() {
        const bool changed = field(before_, "fingerprint") != field(after_, "fingerprint");
        const bool was_on_trial = !field(before_, "trial").is_null();
        const bool is_on_trial = !field(after_, "trial").is_null();
        const std::string_view word = is_on_trial && !was_on_trial ? "on_trial"
                                      : was_on_trial && !is_on_trial
                                          ? (changed ? "went_back" : "kept")
                                          : "changed";
        if (changed || was_on_trial != is_on_trial) {
            add({"configuration", raw_text(after_, "name"), std::string(word), "",
                 "configuration: " + with_blanks(std::string(word))});
        }
    }

    void input(const Json& old, const Json& fresh) {
        const std::string cause = raw_text(fresh, "cause");
        if (raw_text(old, "cause") != cause) {
            const std::string name = raw_text(fresh, "name");
            add({"input", name, cause, raw_text(old, "cause"),
                 fmt::format("input {}: {}", name, with_blanks(cause))},
                whole(fresh, "state_age_us"));
        }
    }

    void output(const Json& old, const Json& fresh) {
        const std::string state = raw_text(fresh, "state");
        const std::string source = raw_text(fresh, "input");
        const bool taken_over = state == "control" && raw_text(old, "input") != source;
        if (raw_text(old, "state") != state || taken_over) {
            const std::string name = raw_text(fresh, "name");
            add({"output", name, state, raw_text(old, "state"),
                 state == "control" ? fmt::format("output {}: under control of {}", name, source)
                                    : fmt::format("output {}: {}", name, with_blanks(state))});
        }
    }

    void port(const Json& old, const Json& fresh) {
        const std::string name = raw_text(fresh, "name");
        const bool present = flag(fresh, "present");
        if (flag(old, "present") != present) {
            const std::string word = present ? "back" : "gone";
            add({"device", name, word, present ? "gone" : "back",
                 fmt::format("device {}: {}", name, word)});
        }
        const std::string bus = raw_text(field(fresh, "can"), "state");
        const std::string bus_before = raw_text(field(old, "can"), "state");
        if (bus != bus_before && !bus.empty()) {
            add({"bus", name, bus, bus_before,
                 fmt::format("CAN interface {}: {}", name, with_blanks(bus))});
        }
    }

    void value(const Json& old, const Json& fresh) {
        if (is_told(old) && is_told(fresh) && flag(old, "stale") != flag(fresh, "stale")) {
            const std::string name = raw_text(fresh, "name");
            const std::string word = flag(fresh, "stale") ? "stale" : "fresh";
            add({"value", name, word, flag(old, "stale") ? "stale" : "fresh",
                 fmt::format("value {}: {}", name, word)});
        }
    }

    const Json& before_;
    const Json& after_;
    Instant now_;
    std::vector<Event> events_;
};

std::string one_line(const OrderedJson& json) {
    // Names of devices may have bytes that are not UTF-8.
    return json.dump(-1, ' ', false, OrderedJson::error_handler_t::replace);
}

}  // namespace

std::vector<std::string_view> event_types() {
    return {kEventTypes.begin(), kEventTypes.end()};
}

std::vector<Event> changes(const Json& before, const Json& after, Instant now) {
    return Changes(before, after, now).take();
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
    const std::string name = raw_text(value, "name");
    return number(value, "age_us") && !name.starts_with("input.") && !name.starts_with("output.");
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
