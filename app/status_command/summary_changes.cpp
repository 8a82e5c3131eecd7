#include <array>
#include <cstdint>
#include <ctime>
#include <string>

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/client/status_fields.h"
#include "app/status_command/summary.h"

namespace tribus::status_summary {
namespace {

using Json = nlohmann::json;
using Ordered = nlohmann::ordered_json;

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

}  // namespace

Ordered of_change(const Json& change) {
    Ordered told{{"type", "change"}};
    for (const char* key :
         {"number", "t_us", "unix_time_us", "part", "name", "field", "was", "now", "text"}) {
        told[key] = status_fields::field(change, key);
    }
    if (change.contains("input")) {
        told["input"] = change["input"];
    }
    return told;
}

Ordered change_of_daemon(const Ordered& summary, const DaemonChange& change) {
    const std::string name = status_fields::raw_text(Json(summary), "name");
    Ordered told{{"type", "change"},      {"number", nullptr},
                 {"t_us", change.t_us},   {"unix_time_us", change.unix_time_us},
                 {"part", "daemon"},      {"name", name},
                 {"field", change.field}, {"was", !change.now},
                 {"now", change.now},     {"text", "daemon " + name + ": " + change.text}};
    if (!change.why.empty()) {
        told["why"] = change.why;
    }
    return told;
}

std::string line(const Ordered& change) {
    const Json plain(change);
    const std::string field = status_fields::raw_text(plain, "field");
    const bool words = field == "cause" || field == "state" || field == "input";
    const std::string was = words ? status_fields::text(plain, "was") : "";
    const std::string why = status_fields::text(plain, "why");
    return fmt::format("{}{}{}{}",
                       time_text(status_fields::number(plain, "unix_time_us").value_or(-1)),
                       status_fields::text(plain, "text"), was.empty() ? "" : ", was " + was,
                       why.empty() ? "" : ": " + why);
}

}  // namespace tribus::status_summary
