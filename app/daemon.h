#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/appliance.h"
#include "app/inside_view.h"
#include "app/preparation.h"
#include "app/service_notify.h"
#include "app/state_log.h"
#include "config/schema.h"
#include "core/time.h"

namespace tribus {

/// What came of the wish for another configuration.
struct ReloadOutcome {
    bool taken = false;
    /// Why not; or, where it was taken, for what the outputs stopped. A line for each thing.
    std::vector<std::string> lines{};
    /// What it is on trial by; nothing where it is not.
    std::optional<std::uint64_t> trial{};
};

/// The configuration that `tribus run` runs, the changes from one to the next, and all who are told
/// of it: log, control socket, service manager. Thread-bound to the main thread.
class Daemon {
  public:
    /// `path` is read again at each reload. The others must outlive it.
    Daemon(std::string path, InsideView& inside, ServiceNotify& service)
        : path_(std::move(path)), inside_(inside), service_(service) {}

    /// Where it cannot be started the log says why, and nothing runs.
    void start(Configuration configuration);
    bool runs() const { return appliance_ != nullptr; }
    /// All below while it runs only.
    const Configuration& configuration() const { return appliance_->configuration(); }

    /// A few times a second: tends devices, tells what changed, ends a trial that nobody confirmed,
    /// and restarts where another node of DroneCAN asked for that.
    void look(Instant now);

    /// Begins to take the file as it is now: it is read and made ready on another thread, and taken
    /// between two frames by `go_on`. One that has mistakes, or whose devices cannot be opened,
    /// leaves the old configuration running as if nothing had been asked for. With a `trial` it
    /// goes back by itself after that time to the configuration that ran before the first
    /// unconfirmed one, unless it is confirmed. Afterwards nothing may run: where what must stop
    /// for it could not be started again. The number of the change; nothing while another one is
    /// under way.
    std::optional<std::uint64_t> begin_reload(std::optional<Duration> trial = std::nullopt);
    /// Somebody wants the file to be read who gets no answer and is no person: a trial stays one.
    /// However often it is said, this happens at most ten times a second.
    void note_hang_up() { hung_up_ = true; }
    /// Which configuration is on trial: each trial has a number of its own.
    std::optional<std::uint64_t> trial() const;
    /// It stays. Only while one is on trial.
    void confirm();
    /// Begins to go back, in any case: also to devices that are missing just now, and from a reload
    /// that is under way. Only while a configuration is on trial. The number of the change.
    std::uint64_t begin_going_back();
    /// What came of a change; nothing while it is under way.
    std::optional<ReloadOutcome> outcome_of(std::uint64_t change) const;

    /// Goes on with what is under way, as far as it can. Call it when `descriptor` can be read, and
    /// when it is `due`.
    void go_on(Instant now);
    /// -1 while nothing is under way.
    int descriptor() const { return change_ ? change_->preparation->descriptor() : -1; }
    Instant due() const;

    /// Outputs end as their failsafe says.
    void end();

  private:
    struct Trial {
        Configuration before;
        Instant end;
        std::uint64_t number = 0;
    };
    enum class ChangeKind : std::uint8_t { reload, hang_up, back };
    /// On its way from one configuration to the next.
    struct Change {
        ChangeKind kind{};
        std::uint64_t number = 0;
        Instant latest_end{};
        std::optional<Duration> trial;
        Configuration before;  ///< of one that goes back
        std::unique_ptr<Preparation> preparation;
    };

    bool start_or_log(std::unique_ptr<Appliance> built, Appliance::MissingDevices missing,
                      std::vector<std::string>& errors);
    std::uint64_t begin(Change change);
    void remember(std::uint64_t change, ReloadOutcome outcome);
    ReloadOutcome finish_reload(Change& change);
    ReloadOutcome finish_going_back(Change& change);
    ReloadOutcome refuse(const std::vector<Mistake>& mistakes);
    ReloadOutcome take(std::unique_ptr<Appliance> fresh);
    ReloadOutcome take_with_a_stop(std::unique_ptr<Appliance> fresh,
                                   std::vector<std::string> obstacles);
    ReloadOutcome take_between_frames(std::unique_ptr<Appliance> fresh,
                                      const CarryOver& carry_over);
    std::optional<Instant> trial_end() const;
    void set_trial(std::optional<Trial> trial);
    void restart();
    void watch();
    void watch_on(const std::vector<PortPlan>& ports_before, const CarryOver& carry_over);

    std::string path_;
    InsideView& inside_;
    ServiceNotify& service_;
    std::unique_ptr<Appliance> appliance_;
    std::unique_ptr<StateLog> log_;
    std::optional<Trial> trial_;
    std::uint64_t trials_ = 0;
    std::optional<Change> change_;
    std::uint64_t changes_ = 0;
    std::map<std::uint64_t, ReloadOutcome> outcomes_;
    bool hung_up_ = false;
    Instant next_hang_up_{};
};

}  // namespace tribus
