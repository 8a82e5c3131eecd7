#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/appliance.h"
#include "app/inside_view.h"
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

    /// Takes the file as it is now between two frames. One that has mistakes, or whose devices
    /// cannot be opened, leaves the old configuration running as if nothing had been asked for.
    /// With a `trial` it goes back by itself after that time to the configuration that ran before
    /// the first unconfirmed one, unless it is confirmed. Afterwards nothing may run: where what
    /// must stop for it could not be started again.
    ReloadOutcome reload(std::optional<Duration> trial = std::nullopt);
    /// Until when the configuration is on trial.
    std::optional<Instant> trial_end() const;
    /// It stays. Only while one is on trial.
    void confirm();
    /// Goes back at once, and in any case: also to devices that are missing just now. Only while a
    /// configuration is on trial.
    ReloadOutcome go_back();

    /// Outputs end as their failsafe says.
    void end();

  private:
    struct Trial {
        Configuration before;
        Instant end;
    };

    bool start_or_log(Configuration configuration, Appliance::MissingDevices missing,
                      std::vector<std::string>& errors);
    ReloadOutcome take(Configuration fresh);
    ReloadOutcome take_with_a_stop(Configuration fresh, std::vector<std::string> obstacles);
    ReloadOutcome take_between_frames(Configuration fresh, const CarryOver& carry_over);
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
};

}  // namespace tribus
