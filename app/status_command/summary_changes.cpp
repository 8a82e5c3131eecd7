#include <array>
#include <cstdint>
#include <ctime>
#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/client/status_fields.h"
#include "app/status_command/summary.h"

namespace tribus::status_summary {
namespace {

using Json = nlohmann::json;
using Ordered = nlohmann::ordered_json;

/// One kind of part in a summary: its list, its word in a change, the fields that are compared, and
/// the counter that tells what was too short to be seen in the first of these fields.
struct PartKind {
    const char* list;
    const char* word;
    std::vector<const char*> fields;
    const char* counter;
};

const std::array<PartKind, 3>& part_kinds() {
    static const std::array<PartKind, 3> kinds{
        {{"inputs", "input", {"cause"}, "times_lost"},
         {"outputs", "output", {"state", "input", "obstacle"}, "failsafe_entries"},
         {"devices", "device", {"state"}, nullptr}}};
    return kinds;
}

const Ordered& value_in(const Ordered& part, const char* field) {
    static const Ordered nothing;
    const auto found = part.is_object() ? part.find(field) : part.end();
    return found == part.end() ? nothing : *found;
}

const Ordered& part_named(const Ordered& list, const Ordered& name) {
    static const Ordered nothing;
    for (const Ordered& part : list) {
        if (value_in(part, "name") == name) {
            return part;
        }
    }
    return nothing;
}

/// Collects the changes that a newer summary brings.
class Changes {
  public:
    explicit Changes(const Ordered& after) : after_(after) {}

    /// Returns whether `field` differs.
    bool compare(const char* word, const Ordered& name, const char* field, const Ordered& was,
                 const Ordered& now) {
        if (was == now) {
            return false;
        }
        found_.push_back({{"type", "change"},
                          {"t_us", value_in(after_, "t_us")},
                          {"unix_time_us", value_in(after_, "unix_time_us")},
                          {"part", word},
                          {"name", name},
                          {"field", field},
                          {"was", was},
                          {"now", now}});
        return true;
    }

    void compare_part(const PartKind& kind, const Ordered& name, const Ordered& before,
                      const Ordered& after) {
        bool seen = false;
        for (const char* field : kind.fields) {
            const bool differs =
                compare(kind.word, name, field, value_in(before, field), value_in(after, field));
            seen = seen || (differs && field == kind.fields.front());
        }
        if (kind.counter != nullptr && !seen) {
            compare(kind.word, name, kind.counter, value_in(before, kind.counter),
                    value_in(after, kind.counter));
        }
    }

    std::vector<Ordered> take() { return std::move(found_); }

  private:
    const Ordered& after_;
    std::vector<Ordered> found_;
};

/// UTC with milliseconds, such as 2026-11-26T21:09:23.411Z. Empty for a time that no clock shows.
std::string time_text(double unix_time_us) {
    constexpr std::int64_t kMsPerSecond = 1000;
    constexpr double kYear3000Us = 32503680000e6;
    if (!(unix_time_us >= 0 && unix_time_us < kYear3000Us)) {
        return "";
    }
    const auto ms = static_cast<std::int64_t>(unix_time_us) / kMsPerSecond;
    return fmt::format("{:%Y-%m-%dT%H:%M:%S}.{:03}Z ",
                       fmt::gmtime(static_cast<std::time_t>(ms / kMsPerSecond)), ms % kMsPerSecond);
}

std::string words_of(const Json& value) {
    return value.is_null()     ? "none"
           : value.is_string() ? status_fields::shown(value.get<std::string>())
                               : status_fields::shown(value.dump());
}

}  // namespace

std::vector<Ordered> changes(const Ordered& before, const Ordered& after) {
    Changes changes(after);
    const Ordered& daemon = value_in(after, "name");
    for (const char* field : {"fingerprint", "trial", "figures_old"}) {
        changes.compare("daemon", daemon, field, value_in(before, field), value_in(after, field));
    }
    for (const PartKind& kind : part_kinds()) {
        const Ordered& then = value_in(before, kind.list);
        const Ordered& now = value_in(after, kind.list);
        for (const Ordered& part : then) {
            const Ordered& name = value_in(part, "name");
            changes.compare_part(kind, name, part, part_named(now, name));
        }
        for (const Ordered& part : now) {
            const Ordered& name = value_in(part, "name");
            if (part_named(then, name).is_null()) {
                changes.compare_part(kind, name, Ordered(), part);
            }
        }
    }
    return changes.take();
}

Ordered change_of_answers(const Ordered& summary, bool answers, const std::string& why,
                          std::int64_t t_us, std::int64_t unix_time_us) {
    Ordered change{{"type", "change"},
                   {"t_us", t_us},
                   {"unix_time_us", unix_time_us},
                   {"part", "daemon"},
                   {"name", value_in(summary, "name")},
                   {"field", "answers"},
                   {"was", !answers},
                   {"now", answers}};
    if (!why.empty()) {
        change["why"] = why;
    }
    return change;
}

std::string line(const Ordered& change) {
    const Json plain(change);
    const std::string why = status_fields::text(plain, "why");
    return fmt::format(
        "{}{} {}: {} {}, was {}{}",
        time_text(status_fields::number(plain, "unix_time_us").value_or(0)),
        status_fields::text(plain, "part"), status_fields::text(plain, "name"),
        status_fields::text(plain, "field"), words_of(status_fields::field(plain, "now")),
        words_of(status_fields::field(plain, "was")), why.empty() ? "" : " (" + why + ")");
}

}  // namespace tribus::status_summary
