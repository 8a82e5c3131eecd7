#include "app/daemon/control_requests.h"

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/cli/object_text.h"
#include "config/show/effective.h"
#include "core/quantity.h"

namespace tribus {
namespace {

using OrderedJson = nlohmann::ordered_json;
using Words = std::span<const std::string>;

constexpr Duration kLeastTrial = std::chrono::seconds(1);
constexpr Duration kMostTrial = std::chrono::hours(1);

std::string outcome_text(const ReloadOutcome& outcome) {
    OrderedJson json{{"type", "outcome"}, {"taken", outcome.taken}, {"lines", outcome.lines}};
    json["trial"] = outcome.trial ? OrderedJson(*outcome.trial) : OrderedJson(nullptr);
    return json_text(json);
}

ControlServer::LateAnswer known(std::string text) {
    return [text = std::move(text)] { return std::optional(text); };
}

/// Outcome of the change, once it has begun and ended. The daemon may have stopped meanwhile, for
/// an earlier request.
std::optional<std::string> outcome_of(const Daemon& daemon, std::optional<std::uint64_t> change) {
    if (!daemon.runs()) {
        return error_object("nothing runs any more");
    }
    const auto outcome = change ? daemon.outcome_of(*change) : std::nullopt;
    return outcome ? std::optional(outcome_text(*outcome)) : std::nullopt;
}

ControlServer::LateAnswer reload(Daemon& daemon, Words words) {
    const auto trial = words.empty() ? std::nullopt : parse_duration(words.front());
    if (words.size() > 1 ||
        (!words.empty() && (!trial || *trial < kLeastTrial || *trial > kMostTrial))) {
        return known(error_object(
            "\"reload\" takes the length of a trial, from \"1s\" to \"3600s\", or nothing"));
    }
    return [&daemon, trial, change = std::optional<std::uint64_t>()]() mutable {
        if (!change && daemon.runs()) {
            change = daemon.begin_reload(trial);
        }
        return outcome_of(daemon, change);
    };
}

/// Nothing if `words` name the present trial, else the reason why it cannot be ended.
std::optional<std::string> why_no_trial(const Daemon& daemon, Words words) {
    const auto trial = daemon.runs() ? daemon.trial() : std::nullopt;
    if (!trial) {
        return "no configuration is on trial";
    }
    if (words.empty() || (words.size() == 1 && words.front() == std::to_string(*trial))) {
        return std::nullopt;
    }
    return fmt::format("that trial is over; the present one is number {}", *trial);
}

std::string confirm(Daemon& daemon, Words words) {
    if (const auto why = why_no_trial(daemon, words)) {
        return error_object(*why);
    }
    daemon.confirm();
    return outcome_text({.taken = true});
}

ControlServer::LateAnswer go_back(Daemon& daemon, Words words) {
    if (const auto why = why_no_trial(daemon, words)) {
        return known(error_object(*why));
    }
    const std::uint64_t change = daemon.begin_going_back();
    return [&daemon, change] { return outcome_of(daemon, change); };
}

}  // namespace

void add_control_requests(ControlServer& control, Daemon& daemon) {
    control.add_late("reload", [&daemon](Words words) { return reload(daemon, words); });
    control.add_late("back", [&daemon](Words words) { return go_back(daemon, words); });
    control.add("confirm", [&daemon](Words words) { return confirm(daemon, words); });
    control.add("configuration", [&daemon](Words) {
        if (!daemon.runs()) {
            return error_object("nothing runs any more");
        }
        return json_text({{"type", "configuration"},
                          {"file", daemon.configuration().file},
                          {"toml", effective_toml(daemon.configuration())}});
    });
}

}  // namespace tribus
