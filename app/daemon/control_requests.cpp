#include "app/daemon/control_requests.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/cli/object_text.h"
#include "config/show/effective.h"
#include "core/quantity.h"
#include "transports/links/unique_fd.h"

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
std::optional<std::string> outcome_of(const Daemon& daemon, std::optional<std::uint64_t> change,
                                      std::string (*text)(const ReloadOutcome&) = outcome_text) {
    if (!daemon.runs()) {
        return error_object("nothing runs any more");
    }
    const auto outcome = change ? daemon.outcome_of(*change) : std::nullopt;
    return outcome ? std::optional(text(*outcome)) : std::nullopt;
}

/// A refusal to confirm has one reason, which is the error.
std::string confirmed_text(const ReloadOutcome& outcome) {
    return outcome.taken ? outcome_text(outcome) : error_object(outcome.lines.front());
}

ControlServer::LateAnswer reload(Daemon& daemon, Words words) {
    const bool draft = !words.empty() && words.front() == "draft";
    const Words time = draft ? words.subspan(1) : words;
    const auto trial = time.empty() ? std::nullopt : parse_duration(time.front());
    const bool right =
        time.empty() ? !draft : trial && *trial >= kLeastTrial && *trial <= kMostTrial;
    if (time.size() > 1 || !right) {
        return known(error_object(
            "\"reload\" takes the length of a trial, from \"1s\" to \"3600s\", or nothing; "
            "\"reload draft\" needs it"));
    }
    return [&daemon, draft, trial, change = std::optional<std::uint64_t>()]() mutable {
        if (!change && daemon.runs()) {
            change = draft ? daemon.begin_reload_of_draft(*trial) : daemon.begin_reload(trial);
        }
        return outcome_of(daemon, change);
    };
}

/// Makes the folder for drafts, for the user and the group of the socket.
std::string make_draft_folder(const std::string& file) {
    const std::filesystem::path path = std::filesystem::path(file).parent_path();
    constexpr mode_t kUserAndGroup = S_IRWXU | S_IRWXG;
    const bool made = ::mkdir(path.c_str(), kUserAndGroup) == 0 || errno == EEXIST;
    // The rights of what another user has put there stay.
    const UniqueFd folder(
        made ? ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC) : -1);
    if (!folder.valid() || ::fchmod(folder.get(), kUserAndGroup) != 0) {
        return error_object(fmt::format("{}: {}", path.string(), std::strerror(errno)));
    }
    return json_text({{"type", "draft"}, {"file", file}});
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

using BeginEnd = std::optional<std::uint64_t> (Daemon::*)();

/// Ends the trial. While another change is under way the trial may end, so it is looked for until
/// this end has begun.
ControlServer::LateAnswer end_trial(Daemon& daemon, Words words, BeginEnd begin,
                                    std::string (*text)(const ReloadOutcome&)) {
    std::vector<std::string> named(words.begin(), words.end());
    if (named.empty() && daemon.runs() && daemon.trial()) {
        // The present one, not one that begins while this waits.
        named.push_back(std::to_string(*daemon.trial()));
    }
    return [&daemon, named = std::move(named), begin, text,
            change = std::optional<std::uint64_t>()]() mutable -> std::optional<std::string> {
        if (!change) {
            if (const auto why = why_no_trial(daemon, named)) {
                return error_object(*why);
            }
            change = (daemon.*begin)();
        }
        return outcome_of(daemon, change, text);
    };
}

}  // namespace

void add_control_requests(ControlServer& control, Daemon& daemon) {
    control.add_late("reload", [&daemon](Words words) { return reload(daemon, words); });
    control.add_late("back", [&daemon](Words words) {
        return end_trial(daemon, words, &Daemon::begin_going_back, outcome_text);
    });
    control.add("draft", [&daemon](Words) { return make_draft_folder(daemon.draft_file()); });
    control.add_late("confirm", [&daemon](Words words) {
        return end_trial(daemon, words, &Daemon::begin_confirming, confirmed_text);
    });
    add_telling_requests(control, daemon);
}

void add_telling_requests(ControlServer& server, Daemon& daemon) {
    server.add("configuration", [&daemon](Words) {
        if (!daemon.runs()) {
            return error_object("nothing runs any more");
        }
        return json_text({{"type", "configuration"},
                          {"file", daemon.configuration().file},
                          {"toml", effective_toml(daemon.configuration())}});
    });
}

}  // namespace tribus
