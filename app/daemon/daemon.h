#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/appliance/appliance.h"
#include "app/changes/change_journal.h"
#include "app/daemon/daemon_sockets.h"
#include "app/daemon/preparation.h"
#include "app/daemon/service_notify.h"
#include "app/log/change_log.h"
#include "app/log/state_log.h"
#include "config/schema/schema.h"
#include "core/time.h"

namespace tribus {

/// Result of a request for another configuration.
struct ReloadOutcome {
    bool taken = false;
    /// If refused: why. If taken: the reasons for which outputs stopped. One line for each.
    std::vector<std::string> lines{};
    /// Number of the trial, if the configuration is on trial.
    std::optional<std::uint64_t> trial{};
};

/// The configuration that `tribus run` runs, and the changes from one to the next. Informs the log,
/// the control socket and the service manager. Thread-bound to the main thread.
class Daemon {
  public:
    /// Each reload reads `path` again. `sockets` and `service` must outlive the daemon.
    Daemon(std::string path, DaemonSockets& sockets, ServiceNotify& service)
        : path_(std::move(path)), sockets_(sockets), service_(service) {}

    /// If the configuration cannot be started, the log says why, and `runs` is false.
    void start(Configuration configuration);
    /// True while a configuration runs.
    bool runs() const { return appliance_ != nullptr; }
    /// This and all functions below: only while `runs` is true.
    const Configuration& configuration() const { return appliance_->configuration(); }

    /// Call it a few times a second. Reopens devices, reports changes, and restarts if another
    /// DroneCAN node asked for it.
    void look(Instant now);

    /// Begins a reload. Another thread reads the file and prepares it; `go_on` takes it between two
    /// frames. If the file has mistakes or its devices cannot be opened, the old configuration goes
    /// on unchanged. With a `trial`, the daemon goes back after that time to the last confirmed
    /// configuration, unless somebody confirms the new one. If outputs must stop for the change and
    /// then cannot be started again, `runs` is false. Returns the number of the change, or nothing
    /// while another change is under way.
    std::optional<std::uint64_t> begin_reload(std::optional<Duration> trial = std::nullopt);
    /// The same for a trial of the draft in `draft_file` of the control socket.
    std::optional<std::uint64_t> begin_reload_of_draft(Duration trial);
    /// Requests a reload for SIGHUP, which gets no answer; a trial stays a trial. At most one such
    /// reload begins each 100 ms, however often this is called.
    void note_hang_up() { hung_up_ = true; }
    /// The file from which a draft is read.
    const std::string& draft_file() const { return sockets_.draft(); }
    /// Number of the trial, if a configuration is on trial. Each trial has its own number.
    std::optional<std::uint64_t> trial() const;
    /// Begins to end the trial, whose configuration stays. If it is that of a draft, another thread
    /// first lets the file have its text (`Preparation::keeping`); if that fails the trial goes on,
    /// and the outcome says why. Only while one is on trial. Returns the number of the change, or
    /// nothing while another change is under way.
    std::optional<std::uint64_t> begin_confirming();
    /// Begins to go back to the configuration before the trial. This also abandons a change that is
    /// under way, and does not wait for missing devices. Only while a configuration is on trial.
    /// Returns the number of the change, or nothing while a draft is taking the place of the file.
    std::optional<std::uint64_t> begin_going_back();
    /// Result of a change; nothing while it is under way.
    std::optional<ReloadOutcome> outcome_of(std::uint64_t change) const;

    /// Continues the change that is under way, without waiting, and ends a trial that nobody
    /// confirmed. Call it when `descriptor` is readable and at `due`.
    void go_on(Instant now);
    /// -1 while no change is under way.
    int descriptor() const { return change_ ? change_->preparation->descriptor() : -1; }
    /// When `go_on` must be called at the latest; `kNever` if nothing is pending.
    Instant due() const;

    /// Each output sends its last frames as its failsafe demands. Returns when that is done.
    void end();

  private:
    using EpochFiles = std::vector<std::shared_ptr<EpochFile>>;
    struct Trial {
        Configuration before;
        EpochFiles before_files;  ///< so that going back waits for no disk
        Instant end;
        std::uint64_t number = 0;
        std::optional<DraftToKeep> draft{};  ///< nothing if the text is that of the file
    };
    enum class ChangeKind : std::uint8_t { reload, hang_up, confirm, back };
    /// A change from one configuration to the next.
    struct Change {
        ChangeKind kind{};
        std::uint64_t number = 0;
        Instant latest_end{};
        std::optional<Duration> trial;
        bool of_draft = false;
        bool is_decided = false;  ///< nobody can abandon it any more
        Configuration before;     ///< only for ChangeKind::back
        EpochFiles before_files;  ///< likewise
        std::unique_ptr<Preparation> preparation;

        bool runs_to_its_end() const { return kind == ChangeKind::back || is_decided; }
    };

    bool start_or_log(std::unique_ptr<Appliance> built, Appliance::MissingDevices missing,
                      std::vector<std::string>& errors);
    std::uint64_t begin(Change change);
    bool abandon_change(std::string_view why);
    void remember(std::uint64_t change, ReloadOutcome outcome);
    ReloadOutcome finish_reload(Change& change);
    ReloadOutcome finish_confirming(Change& change);
    ReloadOutcome finish_going_back(Change& change);
    void confirm();
    ReloadOutcome refuse(const std::vector<Mistake>& mistakes);
    ReloadOutcome take(std::unique_ptr<Appliance> fresh);
    ReloadOutcome take_with_a_stop(std::unique_ptr<Appliance> fresh,
                                   std::vector<std::string> obstacles);
    ReloadOutcome take_between_frames(std::unique_ptr<Appliance> fresh,
                                      const CarryOver& carry_over);
    void set_trial(std::optional<Trial> trial);
    void look_after_parts(Instant now);
    void tell_the_last_changes();
    void look_at_recorders(Instant now);
    void tell_configuration(std::string word, std::string text);
    void restart();
    void stop();
    void show_started();
    void show_successor(const std::vector<PortPlan>& ports_before, const CarryOver& carry_over);

    std::string path_;
    DaemonSockets& sockets_;
    ServiceNotify& service_;
    std::unique_ptr<Appliance> appliance_;
    bool has_started_ = false;
    /// That of the configuration before, until it has written what is pending.
    std::unique_ptr<FlightRecorder> left_over_;
    ChangeJournal journal_;
    ChangeLog change_log_;
    std::uint64_t recorded_ = 0;  ///< number of the newest change that the recorder knows
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
