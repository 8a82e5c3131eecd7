#include "app/control_requests.h"

#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include "config/effective.h"
#include "core/quantity.h"

namespace tribus {
namespace {

using Json = nlohmann::ordered_json;
using Words = std::span<const std::string>;

constexpr Duration kLeastTrial = std::chrono::seconds(1);
constexpr Duration kMostTrial = std::chrono::hours(1);

std::string outcome_text(const ReloadOutcome& outcome) {
    return json_text({{"type", "outcome"}, {"taken", outcome.taken}, {"lines", outcome.lines}});
}

std::string reload(Daemon& daemon, Words words) {
    const auto trial = words.empty() ? std::nullopt : parse_duration(words.front());
    if (words.size() > 1 ||
        (!words.empty() && (!trial || *trial < kLeastTrial || *trial > kMostTrial))) {
        return error_object(
            "\"reload\" takes how long the trial is, from \"1s\" to \"3600s\", "
            "or nothing");
    }
    return outcome_text(daemon.reload(trial));
}

std::string on_trial_only(Daemon& daemon, ReloadOutcome (*what)(Daemon&)) {
    return daemon.trial_end() ? outcome_text(what(daemon))
                              : error_object("no configuration is on trial");
}

}  // namespace

void add_control_requests(ControlServer& control, Daemon& daemon) {
    const auto add = [&](const char* name, auto answer) {
        control.add(name, [&daemon, answer](Words words) {
            // An earlier request of the same moment may have ended it.
            return daemon.runs() ? answer(daemon, words) : error_object("nothing runs any more");
        });
    };
    add("reload", reload);
    add("confirm", [](Daemon& asked, Words) {
        return on_trial_only(asked, [](Daemon& tried) {
            tried.confirm();
            return ReloadOutcome{.taken = true};
        });
    });
    add("back", [](Daemon& asked, Words) {
        return on_trial_only(asked, [](Daemon& tried) { return tried.go_back(); });
    });
    add("configuration", [](Daemon& asked, Words) {
        return json_text({{"type", "configuration"},
                          {"file", asked.configuration().file},
                          {"toml", effective_toml(asked.configuration())}});
    });
}

}  // namespace tribus
