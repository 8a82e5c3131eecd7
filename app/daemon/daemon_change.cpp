#include <algorithm>
#include <chrono>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "app/cli/load_or_explain.h"
#include "app/daemon/daemon.h"
#include "app/journal/log.h"
#include "config/show/effective.h"
#include "pipelines/realtime/clock.h"

/// The daemon's way from one configuration to the next. Slow work runs on another thread.
namespace tribus {
namespace {

/// A file that takes longer is on a disk that does not answer.
constexpr Duration kLongestReading = std::chrono::minutes(1);
/// Least time from one reload by SIGHUP to the next.
constexpr Duration kHangUpPause = std::chrono::milliseconds(100);
constexpr std::string_view kWentBack = "abandoned: the daemon went back from the trial before it";
/// Upper limit of the remembered outcomes.
constexpr std::size_t kRememberedOutcomes = 16;

}  // namespace

std::uint64_t Daemon::begin(Change change) {
    const Instant now = monotonic_now();
    if (change.kind != ChangeKind::confirm) {
        service_.reloading();
    }
    change.number = ++changes_;
    change.latest_end = later(now, kLongestReading);
    change_.emplace(std::move(change));
    return changes_;
}

void Daemon::remember(std::uint64_t change, ReloadOutcome outcome) {
    outcomes_.insert_or_assign(change, std::move(outcome));
    if (outcomes_.size() > kRememberedOutcomes) {
        outcomes_.erase(outcomes_.begin());
    }
}

std::optional<std::uint64_t> Daemon::begin_reload(std::optional<Duration> trial) {
    if (change_) {
        return std::nullopt;
    }
    return begin({.kind = ChangeKind::reload,
                  .trial = trial,
                  .before = {},
                  .before_files = {},
                  .preparation = Preparation::of_file(path_)});
}

std::optional<std::uint64_t> Daemon::begin_reload_of_draft(Duration trial) {
    if (change_) {
        return std::nullopt;
    }
    return begin({.kind = ChangeKind::reload,
                  .trial = trial,
                  .of_draft = true,
                  .before = {},
                  .before_files = {},
                  .preparation = Preparation::of_draft(sockets_.draft(), path_)});
}

std::optional<std::uint64_t> Daemon::begin_confirming() {
    if (change_) {
        return std::nullopt;
    }
    if (!trial_->draft) {
        confirm();
        remember(++changes_, {.taken = true});
        return changes_;
    }
    return begin({.kind = ChangeKind::confirm,
                  .trial = {},
                  .before = {},
                  .before_files = {},
                  .preparation = Preparation::keeping(*trial_->draft)});
}

/// The file must have the text of the draft, so that the next start runs the same.
ReloadOutcome Daemon::finish_confirming(Change& change) {
    const auto kept = change.preparation->take();
    if (!kept) {
        return {.lines = {format_mistake(kept.error().front())}};
    }
    if (kept->text != trial_->draft->text) {
        return {
            .lines = {fmt::format("{} does not have the text of the draft that is on trial; write "
                                  "it there, then confirm",
                                  path_)}};
    }
    confirm();
    return {.taken = true};
}

/// False while a draft takes the place of the file. Who asked for the change reads `why`.
bool Daemon::abandon_change(std::string_view why) {
    if (change_ && !change_->preparation->abandon()) {
        change_->is_decided = true;
        return false;
    }
    if (change_) {
        remember(change_->number, {.lines = {std::string(why)}});
        change_.reset();
    }
    return true;
}

std::optional<std::uint64_t> Daemon::begin_going_back() {
    if (!abandon_change(kWentBack)) {
        return std::nullopt;
    }
    if (trial_->draft) {
        log_warning("going back to the configuration before, which {} still holds", path_);
    } else {
        log_warning(
            "going back to the configuration before; {} still holds the one that was on trial",
            path_);
    }
    Configuration before = std::move(trial_->before);
    EpochFiles before_files = std::move(trial_->before_files);
    set_trial(std::nullopt);
    auto preparation = Preparation::of(before);
    return begin({.kind = ChangeKind::back,
                  .trial = {},
                  .before = std::move(before),
                  .before_files = std::move(before_files),
                  .preparation = std::move(preparation)});
}

std::optional<ReloadOutcome> Daemon::outcome_of(std::uint64_t change) const {
    const auto outcome = outcomes_.find(change);
    return outcome == outcomes_.end() ? std::nullopt : std::optional(outcome->second);
}

Instant Daemon::due() const {
    const Instant trial_end = trial_ ? trial_->end : kNever;
    if (change_) {
        return change_->runs_to_its_end() ? kNever : std::min(trial_end, change_->latest_end);
    }
    return hung_up_ ? std::min(trial_end, next_hang_up_) : trial_end;
}

void Daemon::go_on(Instant now) {
    if (change_ && change_->preparation->done()) {
        Change change = std::move(*change_);
        change_.reset();
        remember(change.number, change.kind == ChangeKind::back      ? finish_going_back(change)
                                : change.kind == ChangeKind::confirm ? finish_confirming(change)
                                                                     : finish_reload(change));
        next_hang_up_ = later(now, kHangUpPause);
    } else if (change_ && !change_->runs_to_its_end() && now >= change_->latest_end) {
        const Mistake unread{path_, {}, "was not read within a minute", true};
        const bool reloads = change_->kind != ChangeKind::confirm;
        if (abandon_change(format_mistake(unread)) && reloads) {
            refuse({unread});
        }
    }
    if (trial_ && appliance_ && now >= trial_->end && abandon_change(kWentBack)) {
        log_warning("the trial was not confirmed");
        begin_going_back();
    }
    if (hung_up_ && !change_ && appliance_ && now >= next_hang_up_) {
        hung_up_ = false;
        begin({.kind = ChangeKind::hang_up,
               .trial = {},
               .before = {},
               .before_files = {},
               .preparation = Preparation::of_file(path_)});
    }
}

ReloadOutcome Daemon::refuse(const std::vector<Mistake>& mistakes) {
    explain_mistakes(mistakes);
    log_error("reload refused: {} {}; the old configuration runs on", path_,
              may_be_temporary(mistakes) ? "cannot be read as a whole" : "has mistakes");
    service_.started(monotonic_now());
    ReloadOutcome outcome;
    for (const Mistake& mistake : mistakes) {
        outcome.lines.push_back(format_mistake(mistake));
    }
    return outcome;
}

ReloadOutcome Daemon::finish_reload(Change& change) {
    auto fresh = change.preparation->take();
    if (!fresh) {
        return refuse(fresh.error());
    }
    Configuration before = trial_ ? trial_->before : configuration();
    EpochFiles before_files = trial_ ? trial_->before_files : appliance_->epoch_files();
    const std::string text_before = effective_toml(configuration());
    ReloadOutcome outcome = take(std::move(fresh->appliance));
    if (!outcome.taken) {
        return outcome;
    }
    if (change.trial) {
        tell_configuration("on_trial", "is on trial");
    } else if (effective_toml(configuration()) != text_before) {
        tell_configuration("changed", "is another one");
    } else if (trial_ && change.kind != ChangeKind::hang_up) {
        tell_configuration("kept", "is kept");
    }
    if (change.trial) {
        log_info("on trial for {} s: without confirmation the daemon goes back",
                 std::chrono::ceil<std::chrono::seconds>(*change.trial).count());
        set_trial(Trial{std::move(before), std::move(before_files),
                        later(monotonic_now(), *change.trial), ++trials_,
                        change.of_draft ? std::optional(DraftToKeep{path_, std::move(fresh->text),
                                                                    std::move(fresh->file_text)})
                                        : std::nullopt});
    } else if (trial_ && change.kind == ChangeKind::hang_up) {
        trial_->draft.reset();
        log_info("still on trial: SIGHUP does not confirm it");
    } else {
        set_trial(std::nullopt);
    }
    outcome.trial = trial();
    return outcome;
}

ReloadOutcome Daemon::finish_going_back(Change& change) {
    ReloadOutcome outcome = take(std::move(change.preparation->take()->appliance));
    if (outcome.taken) {
        tell_configuration("went_back", "went back to the one before");
    }
    if (outcome.taken || !appliance_) {
        return outcome;
    }
    // The configuration before the trial must run, whatever has been unplugged since.
    log_warning("starting it anyway, with a stop: outputs go into failsafe");
    stop();
    std::vector<std::string> errors;
    outcome.taken = start_or_log(Appliance::build(std::move(change.before)),
                                 Appliance::MissingDevices::wait_for, errors);
    show_started();
    tell_configuration("went_back", "went back to the one before");
    return outcome;
}

}  // namespace tribus
