#include "app/daemon/daemon.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include <fmt/format.h>

#include "app/journal/log.h"
#include "config/build/carry_over.h"
#include "core/counted.h"
#include "pipelines/realtime/clock.h"
#include "pipelines/realtime/thread_notices.h"

namespace tribus {
namespace {

std::string summary(const Configuration& configuration) {
    const std::size_t buses = configuration.sensor_buses.size();
    return fmt::format("{}: {}, {}, {}{}", configuration.file,
                       counted(configuration.inputs.size(), "input"),
                       counted(configuration.outputs.size(), "output"),
                       counted(configuration.pipelines.size(), "pipeline"),
                       buses == 0 ? "" : ", " + counted(buses, "sensor bus", "sensor buses"));
}

void log_all(const std::vector<std::string>& errors) {
    for (const std::string& error : errors) {
        log_error("{}", error);
    }
}

}  // namespace

/// Reports an appliance that has just started.
void Daemon::show_started() {
    if (!appliance_) {
        sockets_.hide();
        return;
    }
    const Instant now = monotonic_now();
    journal_.begin(*appliance_, now, wall_time_now());
    // The user asked for this failsafe.
    recorded_ = journal_.newest();
    log_ = std::make_unique<StateLog>(*appliance_, now);
    log_->log_interfaces(*appliance_);
    sockets_.show(*appliance_, journal_);
    service_.started(now);
}

/// Reports an appliance that replaced another one, which had `ports_before`.
void Daemon::show_successor(const std::vector<PortPlan>& ports_before,
                            const CarryOver& carry_over) {
    const Instant now = monotonic_now();
    journal_.go_on_with(*appliance_, carry_over, now, wall_time_now());
    auto log = std::make_unique<StateLog>(*appliance_, now);
    log->go_on_from(*log_, *appliance_, carry_over);
    log_ = std::move(log);
    const bool new_port = std::ranges::any_of(appliance_->ports(), [&](const PortPlan& port) {
        return std::ranges::none_of(ports_before, [&](const PortPlan& before) {
            return same_device(before.config, port.config);
        });
    });
    if (new_port) {
        log_->log_interfaces(*appliance_);
    }
    // Opens the devices that got other line settings; those that are still missing are told then.
    look_after_parts(now);
    journal_.add(appliance_->devices(), now, wall_time_now());
    sockets_.show(*appliance_, journal_);
    service_.started(now);
}

bool Daemon::start_or_log(std::unique_ptr<Appliance> built, Appliance::MissingDevices missing,
                          std::vector<std::string>& errors) {
    auto appliance = has_started_ ? Appliance::start(std::move(built), missing, left_over_)
                                  : Appliance::start(std::move(built), missing);
    has_started_ = true;
    if (!appliance) {
        errors = std::move(appliance.error());
        log_all(errors);
        return false;
    }
    appliance_ = std::move(*appliance);
    for (const std::string& lack : appliance_->missing_realtime()) {
        log_warning("no full real time: {}", lack);
    }
    for (const std::string& absent : appliance_->waits_for()) {
        log_warning("{}; waiting for it", absent);
    }
    log_info("started {}", summary(appliance_->configuration()));
    return true;
}

void Daemon::start(Configuration configuration) {
    std::vector<std::string> errors;
    start_or_log(Appliance::build(std::move(configuration)),
                 Appliance::MissingDevices::wait_for_absent, errors);
    show_started();
}

/// A recorder goes on in the next appliance, or finishes by itself: no output waits for a disk.
void Daemon::stop() {
    tell_the_last_changes();
    look_at_recorders(monotonic_now());
    if (auto recorder = Appliance::stop(std::move(appliance_))) {
        left_over_ = std::move(recorder);
    }
}

/// For changes that need a stop. If devices of the new configuration cannot be opened, the old one
/// starts again, even if one of its own devices is unplugged now.
ReloadOutcome Daemon::take_with_a_stop(std::unique_ptr<Appliance> fresh,
                                       std::vector<std::string> obstacles) {
    for (const std::string& obstacle : obstacles) {
        log_warning("reload with a stop, outputs go into failsafe: {}", obstacle);
    }
    Configuration old = configuration();
    const EpochFiles old_files = appliance_->epoch_files();
    stop();
    ReloadOutcome outcome;
    outcome.taken =
        start_or_log(std::move(fresh), Appliance::MissingDevices::refuse, outcome.lines);
    if (outcome.taken) {
        outcome.lines = std::move(obstacles);
    } else {
        log_error("reload failed; back to the old configuration");
        std::vector<std::string> ignored;
        start_or_log(Appliance::build(std::move(old)), Appliance::MissingDevices::wait_for,
                     ignored);
    }
    show_started();
    return outcome;
}

ReloadOutcome Daemon::take_between_frames(std::unique_ptr<Appliance> fresh,
                                          const CarryOver& carry_over) {
    const std::string file = fresh->configuration().file;
    const std::vector<PortPlan> ports_before = appliance_->ports();
    auto next = Appliance::succeed(appliance_, std::move(fresh), carry_over, left_over_);
    if (!next) {
        log_all(next.error());
        log_error("reload refused: {} cannot be set up; the old configuration runs on", file);
        service_.started(monotonic_now());
        return {.lines = std::move(next.error())};
    }
    appliance_ = std::move(*next);
    // The log has the last changes of the old configuration before this line.
    journal_.take_the_last_before(*appliance_, monotonic_now(), wall_time_now());
    change_log_.look(journal_, monotonic_now());
    change_log_.flush();
    log_info("reloaded {}", summary(configuration()));
    show_successor(ports_before, carry_over);
    return {.taken = true};
}

ReloadOutcome Daemon::take(std::unique_ptr<Appliance> fresh) {
    const CarryOver carry_over = plan_carry_over(configuration(), fresh->configuration());
    return carry_over.obstacles.empty() ? take_between_frames(std::move(fresh), carry_over)
                                        : take_with_a_stop(std::move(fresh), carry_over.obstacles);
}

std::optional<std::uint64_t> Daemon::trial() const {
    return trial_ ? std::optional(trial_->number) : std::nullopt;
}

void Daemon::set_trial(std::optional<Trial> trial) {
    trial_ = std::move(trial);
    sockets_.show_trial(trial_ ? std::optional(ShownTrial{trial_->number, trial_->end})
                               : std::nullopt);
}

void Daemon::tell_configuration(std::string word, std::string text) {
    const Instant now = monotonic_now();
    journal_.add({.at = now,
                  .wall_time = wall_time_now(),
                  .part = "configuration",
                  .name = std::filesystem::path(path_).stem().string(),
                  .field = "state",
                  .now = std::move(word),
                  .text = std::move(text),
                  .kind = "configuration"});
}

void Daemon::confirm() {
    tell_configuration("kept", "is kept");
    log_info("confirmed: the configuration stays");
    set_trial(std::nullopt);
}

/// Another DroneCAN node asked for it.
void Daemon::restart() {
    service_.reloading();
    log_info("restarting because another DroneCAN node asked for it");
    Configuration same = configuration();
    const EpochFiles same_files = appliance_->epoch_files();
    appliance_->end();
    stop();
    std::vector<std::string> errors;
    start_or_log(Appliance::build(std::move(same)), Appliance::MissingDevices::wait_for, errors);
    show_started();
}

/// Takes the last changes of an appliance that will stop, or has.
void Daemon::tell_the_last_changes() {
    const Instant now = monotonic_now();
    journal_.look(*appliance_, now, wall_time_now());
    change_log_.look(journal_, now);
    change_log_.flush();
}

/// Opens devices that are back, and tells what has changed.
void Daemon::look_after_parts(Instant now) {
    const Appliance::DeviceNews news = appliance_->look_after_devices(now);
    journal_.add(news.events, now, wall_time_now());
    journal_.look(*appliance_, now, wall_time_now());
    change_log_.look(journal_, now);
    log_->look(*appliance_, news, now);
    for (const std::string& text : take_thread_notices()) {
        log_warning("{}", text);
    }
}

void Daemon::look_at_recorders(Instant now) {
    std::vector<FailsafeEntry> entries;
    for (const ToldChange& change : journal_.since(std::exchange(recorded_, journal_.newest()))) {
        const bool was_fed = change.was == "control" || change.was == "hold";
        // An input may have such a name.
        if (change.part == "output" && change.field == "state" && was_fed &&
            (change.now == "failsafe" || change.now == "silent")) {
            entries.push_back({change.name, change.at, change.wall_time});
        }
    }
    if (FlightRecorder* const recorder = appliance_->recorder()) {
        recorder->look(entries, now, wall_time_now());
    }
    if (left_over_ && left_over_->finish(now, wall_time_now())) {
        left_over_.reset();
    }
}

void Daemon::look(Instant now) {
    if (appliance_->restart_wanted()) {
        restart();
    }
    if (!appliance_) {
        return;
    }
    if (appliance_->data_thread_failed()) {
        log_error("{}; the program ends", appliance_->data_thread_failure());
        appliance_.reset();
        return;
    }
    look_after_parts(now);
    appliance_->look_at_machine(now, sockets_.watched());
    sockets_.look();
    service_.look(*appliance_, now);
    look_at_recorders(now);
    appliance_->look_at_epochs();
}

void Daemon::end() {
    service_.stopping();
    appliance_->end();
    tell_the_last_changes();
    log_info("stopped");
}

}  // namespace tribus
