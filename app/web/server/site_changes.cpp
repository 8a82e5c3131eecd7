#include <fstream>
#include <memory>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/cli/replace_file.h"
#include "app/client/draft.h"
#include "app/client/parse_json.h"
#include "app/client/status_fields.h"
#include "app/status/fingerprint.h"
#include "app/web/answers/answers.h"
#include "app/web/answers/checks.h"
#include "app/web/server/site.h"
#include "config/language/read_document.h"
#include "config/language/read_file.h"
#include "pipelines/realtime/clock.h"

/// Changes by a page: a draft goes on trial, and stays or goes back.
namespace tribus::web {
namespace {

/// A reload opens devices and may read large files.
constexpr Duration kReloadPatience = std::chrono::seconds(70);
constexpr std::int64_t kUsualTrialSeconds = 30;
constexpr std::int64_t kMostTrialSeconds = 3600;

std::string fingerprint_of(const std::filesystem::path& file) {
    const auto text = read_file(file, kMostConfigurationBytes, FileKinds::regular);
    return text ? fingerprint(*text) : std::string();
}

/// The text in quotation marks of If-Match.
std::string tag_in(const std::string& if_match) {
    const std::size_t begin = if_match.find('"');
    const std::size_t end = if_match.rfind('"');
    return begin == std::string::npos || end <= begin ? std::string()
                                                      : if_match.substr(begin + 1, end - begin - 1);
}

HttpAnswer changed_meanwhile(const std::string& present) {
    return json_answer(
        {{"error", "the file was changed by another meanwhile"}, {"fingerprint", present}}, 412);
}

/// A daemon that refuses to end a trial is 409; one that does not answer is 502, and nobody knows
/// what it did.
HttpAnswer not_ended(const std::string& outcome) {
    const auto told = parse_json(outcome);
    const std::string why = status_fields::text(told, "error");
    return status_fields::flag(told, "unanswered")
               ? refused(502, why + "; what became of the trial is seen when it answers again")
               : refused(409, why);
}

std::optional<std::uint64_t> trial_in(const HttpRequest& request) {
    const auto trial = number_in(request.body, "trial");
    return trial && *trial >= 1 ? std::optional(static_cast<std::uint64_t>(*trial)) : std::nullopt;
}

HttpAnswer no_trial() {
    return refused(400, "the number of the trial is missing");
}

}  // namespace

Site::Reply Site::record(const Asked& asked) {
    return ask_to_change(asked.daemon, "record", asked.now, as_it_is);
}

Site::Reply Site::take_draft_back(const Asked& asked) {
    const auto trial = trial_in(asked.request);
    if (!trial) {
        return no_trial();
    }
    return ask_to_change(
        asked.daemon, fmt::format("back {}", *trial), asked.now,
        [](const std::string& json) {
            HttpAnswer answer = as_it_is(json);
            return answer.status == 200 ? answer : not_ended(json);
        },
        kReloadPatience);
}

/// Why the text of a draft is refused; nothing if it may take the place of the file.
std::optional<HttpAnswer> Site::why_no_draft(const Asked& asked, const std::string& text) {
    const std::filesystem::path& file = asked.daemon.file;
    if (file.empty()) {
        return refused(404, "its configuration is not in the folder of configurations");
    }
    const std::string present = fingerprint_of(file);
    if (tag_in(asked.request.if_match) != present) {
        return changed_meanwhile(present);
    }
    Json checked = check_draft(text, file);
    if (!checked["mistakes"].empty()) {
        checked["error"] = "the draft has mistakes";
        return json_answer(checked, 400);
    }
    return std::nullopt;
}

Site::Reply Site::begin_draft(const Asked& asked) {
    const auto& [request, visitor, daemon, name, who, now] = asked;
    auto text = text_in(request.body, "toml");
    const std::int64_t seconds = number_in(request.body, "seconds").value_or(kUsualTrialSeconds);
    if (!text || seconds < 1 || seconds > kMostTrialSeconds) {
        return refused(400, "a draft needs its text, and from 1 to 3600 seconds");
    }
    if (auto why = why_no_draft(asked, *text)) {
        return *std::move(why);
    }
    if (daemon.tells.empty()) {
        return refused(502, fmt::format("no daemon runs {}", daemon.name));
    }
    return run_draft(daemon, {.text = *std::move(text), .before = tag_in(request.if_match)},
                     seconds, now);
}

/// Without a daemon nothing can be tried: the file had mistakes, or its service is off.
Site::Reply Site::save(const Asked& asked) {
    const KnownDaemon& daemon = asked.daemon;
    const auto text = text_in(asked.request.body, "toml");
    if (!text) {
        return refused(400, "the text is missing");
    }
    if (!daemon.tells.empty()) {
        return refused(409, "a daemon runs it; a change goes on trial first");
    }
    if (auto why = why_no_draft(asked, *text)) {
        return *std::move(why);
    }
    const auto kept =
        keep_configuration(daemon.file, *text, settings_.state / "history" / daemon.name);
    return kept ? json_answer({{"fingerprint", fingerprint(*text)}}) : refused(500, kept.error());
}

/// Asks for the folder, writes the draft there, and lets it run.
Site::Reply Site::run_draft(const KnownDaemon& daemon, Draft draft, std::int64_t seconds,
                            Instant now) {
    const auto own = std::make_shared<Draft>(std::move(draft));
    auto folder = ask_to_change(daemon, "draft", now, as_it_is);
    if (std::holds_alternative<HttpAnswer>(folder)) {
        return folder;
    }
    auto running = std::make_shared<std::optional<Late>>();
    return Late([this, daemon, own, seconds, running,
                 folder = std::get<Late>(std::move(folder))]() -> std::optional<HttpAnswer> {
        if (*running) {
            return (**running)();
        }
        auto made = folder();
        if (!made || made->status != 200) {
            return made;
        }
        if (!write_draft(daemon.control, own->text)) {
            return refused(500, "the draft cannot be written beside the control socket");
        }
        auto reply = ask_to_change(
            daemon, fmt::format("reload draft {}s", seconds), monotonic_now(),
            [this, name = daemon.name, own](const std::string& outcome) {
                HttpAnswer answer = as_it_is(outcome);
                const auto told = parse_json(outcome);
                if (const auto trial = status_fields::number(told, "trial")) {
                    own->trial = static_cast<std::uint64_t>(*trial);
                    drafts_[name] = *own;
                }
                return answer;
            },
            kReloadPatience);
        *running = std::get<Late>(std::move(reply));
        return std::nullopt;
    });
}

/// A trial that another program began is confirmed without a file.
Site::Reply Site::keep_draft(const Asked& asked) {
    const KnownDaemon& daemon = asked.daemon;
    const auto trial = trial_in(asked.request);
    if (!trial) {
        return no_trial();
    }
    if (daemon.control.empty()) {
        return refused(502, fmt::format("no daemon runs {}; the file is as before", daemon.name));
    }
    const auto draft = drafts_.find(daemon.name);
    if (draft != drafts_.end() && draft->second.trial == *trial) {
        return keep_own_draft(asked, draft->second);
    }
    return ask_to_change(
        daemon, fmt::format("confirm {}", *trial), asked.now,
        [file = daemon.file](const std::string& outcome) {
            return as_it_is(outcome).status == 200
                       ? json_answer({{"kept", true}, {"fingerprint", fingerprint_of(file)}})
                       : not_ended(outcome);
        },
        kReloadPatience);
}

/// The daemon alone decides, and puts the file in place. This only writes the successor of the file
/// beside it, which shows that it may write there.
Site::Reply Site::keep_own_draft(const Asked& asked, Draft& draft) {
    const KnownDaemon& daemon = asked.daemon;
    if (draft.is_being_kept) {
        return refused(409, "this draft is being kept already");
    }
    const std::string present = fingerprint_of(daemon.file);
    if (present != draft.before) {
        return changed_meanwhile(present);
    }
    const auto written = write_next_configuration(daemon.file, draft.text,
                                                  settings_.state / "history" / daemon.name);
    if (!written) {
        return refused(500, written.error() + "; the file is as before");
    }
    draft.is_being_kept = true;
    return ask_to_change(
        daemon, fmt::format("confirm {}", draft.trial), asked.now,
        [this, file = daemon.file, name = daemon.name, trial = draft.trial,
         wanted = fingerprint(draft.text)](const std::string& outcome) {
            remove_successor(linked_file(file));
            const auto own = drafts_.find(name);
            if (own != drafts_.end() && own->second.trial == trial) {
                own->second.is_being_kept = false;
            }
            if (as_it_is(outcome).status != 200) {
                return not_ended(outcome);
            }
            // By SIGHUP the file itself may have gone on trial in place of the draft.
            if (fingerprint_of(file) != wanted) {
                return refused(409, "what the file has was on trial, and is kept");
            }
            drafts_.erase(name);
            return json_answer({{"kept", true}, {"fingerprint", wanted}});
        },
        kReloadPatience);
}

}  // namespace tribus::web
