#include "app/status_command/summary.h"

#include <cstdint>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/cli/screen_parts.h"
#include "app/client/status_fields.h"
#include "app/monitor/monitor_lines.h"
#include "core/time.h"

namespace tribus::status_summary {
namespace {

using Json = nlohmann::json;
using Ordered = nlohmann::ordered_json;

/// A daemon publishes figures ten times a second; older ones are a hung data thread's last.
constexpr Duration kYoung = std::chrono::seconds(1);
constexpr const char* kUnknown = "unknown";

std::uint64_t total(const Json& counts) {
    std::uint64_t sum = 0;
    for (const Json& count : counts) {
        sum += count.is_number_unsigned() ? count.get<std::uint64_t>() : 0;
    }
    return sum;
}

Ordered input_of(const Json& input, bool old) {
    return {{"name", status_fields::field(input, "name")},
            {"good", !old && status_fields::raw_text(input, "cause") == "good"},
            {"cause", old ? Json(kUnknown) : status_fields::field(input, "cause")},
            {"text", old ? Json(kUnknown) : status_fields::field(input, "text")},
            {"age_us", status_fields::field(input, "age_us")},
            {"times_lost", total(status_fields::field(input, "losses"))}};
}

Ordered output_of(const Json& output, bool old) {
    return {{"name", status_fields::field(output, "name")},
            {"state", old ? Json(kUnknown) : status_fields::field(output, "state")},
            {"obstacle", old ? Json() : status_fields::field(output, "obstacle")},
            {"input", old ? Json() : status_fields::field(output, "input")},
            {"text", old ? Json(kUnknown) : status_fields::field(output, "text")},
            {"waits_for", old ? Json() : status_fields::field(output, "waits_for")},
            {"why", old ? Json() : status_fields::field(output, "why")},
            {"failsafe_entries", status_fields::count(output, "failsafe_entries")}};
}

std::string device_state(const Json& port) {
    const Json& can = status_fields::field(port, "can");
    return !status_fields::flag(port, "present") ? "gone"
           : can.is_object()                     ? status_fields::raw_text(can, "state")
                                                 : "there";
}

void add_devices(Ordered& summary, const Json& status, bool old) {
    Ordered devices = Ordered::array();
    Ordered gone = Ordered::array();
    for (const Json& port : status_fields::list(status, "ports")) {
        const std::string state = old ? kUnknown : device_state(port);
        devices.push_back({{"name", status_fields::field(port, "name")}, {"state", state}});
        if (state == "gone") {
            gone.push_back(Ordered(status_fields::field(port, "name")));
        }
    }
    summary["devices"] = std::move(devices);
    summary["gone"] = std::move(gone);
}

std::string first_line(const Json& summary) {
    const std::string name = status_fields::text(summary, "name");
    const std::string age = short_duration(monitor::us_of(summary, "figures_age_us"));
    if (status_fields::flag(summary, "figures_old")) {
        return fmt::format("{}: STANDS STILL since {}", name, age);
    }
    return fmt::format("{}: up {}, figures {} old, configuration {} ({})", name,
                       short_duration(monitor::us_of(summary, "uptime_us")), age,
                       status_fields::text(summary, "file"),
                       status_fields::text(summary, "fingerprint"));
}

/// A daemon of an older version gives the cause only.
std::string input_words(const Json& input) {
    const bool ever = status_fields::number(input, "age_us").has_value();
    const std::string text = status_fields::text(input, "text");
    return fmt::format(
        "input {}: {}, {}", status_fields::text(input, "name"),
        text.empty() ? status_fields::text(input, "cause") : text,
        ever ? fmt::format("newest frame {} old", short_duration(monitor::us_of(input, "age_us")))
             : "no frame yet");
}

std::string output_words(const Json& output) {
    const std::string text = status_fields::text(output, "text");
    const std::string why = status_fields::text(output, "why");
    return fmt::format("output {}: {}{}", status_fields::text(output, "name"),
                       text.empty() ? status_fields::text(output, "state") : text,
                       why.empty() ? "" : "; " + why);
}

}  // namespace

tl::expected<Ordered, std::string> of_status(const Json& status) {
    if (status_fields::raw_text(status, "type") != "status") {
        return tl::unexpected(std::string("what answers is no status of tribus"));
    }
    Ordered summary{{"type", "summary"}, {"version", kVersion}};
    for (const char* key :
         {"name", "file", "fingerprint", "t_us", "unix_time_us", "uptime_us", "figures_age_us"}) {
        summary[key] = status_fields::field(status, key);
    }
    const bool known = status_fields::number(status, "figures_age_us").has_value();
    const bool old = !known || monitor::us_of(status, "figures_age_us") > kYoung;
    summary["figures_old"] = old;
    summary["trial"] = status_fields::field(status, "trial");
    summary["trial_left_us"] = status_fields::field(status, "trial_left_us");
    summary["inputs"] = Ordered::array();
    for (const Json& input : status_fields::list(status, "inputs")) {
        summary["inputs"].push_back(input_of(input, old));
    }
    summary["outputs"] = Ordered::array();
    for (const Json& output : status_fields::list(status, "outputs")) {
        summary["outputs"].push_back(output_of(output, old));
    }
    add_devices(summary, status, old);
    return summary;
}

std::vector<std::string> lines(const Ordered& summary) {
    const Json plain(summary);
    std::vector<std::string> lines{first_line(plain)};
    if (const auto left = status_fields::number(plain, "trial_left_us")) {
        lines.push_back(fmt::format("trial {}: goes back in {} unless confirmed",
                                    status_fields::count(plain, "trial"),
                                    short_duration(monitor::us_of(plain, "trial_left_us"))));
    }
    for (const Json& input : status_fields::list(plain, "inputs")) {
        lines.push_back(input_words(input));
    }
    for (const Json& output : status_fields::list(plain, "outputs")) {
        lines.push_back(output_words(output));
    }
    for (const Json& device : status_fields::list(plain, "devices")) {
        lines.push_back(fmt::format("device {}: {}", status_fields::text(device, "name"),
                                    status_fields::text(device, "state")));
    }
    return lines;
}

}  // namespace tribus::status_summary
