#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "app/appliance/appliance.h"
#include "app/changes/change_journal.h"
#include "app/daemon/control_server.h"
#include "app/status/status.h"
#include "core/time.h"

namespace tribus {

/// A trial as a status shows it.
struct ShownTrial {
    std::uint64_t number = 0;
    Instant end;
};

/// The control socket of a running daemon, the socket that only tells, and what clients see there.
/// Thread-bound to the main thread, which waits for `descriptors` and `due`; no function here
/// waits.
class DaemonSockets {
  public:
    /// Opens the control socket of the daemon that runs `config`, at `socket` or in the default
    /// place. An error, a sentence, can only come from a given `socket`. If there is no default
    /// place or it is in use, the daemon runs without a control socket, and the log says so.
    static tl::expected<std::unique_ptr<DaemonSockets>, std::string> open(
        const std::string& config, const std::optional<std::string>& socket);
    DaemonSockets(const DaemonSockets&) = delete;
    DaemonSockets& operator=(const DaemonSockets&) = delete;

    /// From now on it shows `appliance` and its changes, which must live until the next `show` or
    /// `hide`.
    void show(const Appliance& appliance, ChangeJournal& changes);
    /// Call it when no appliance runs any more.
    void hide() { keeper_.reset(); }
    /// Nothing while no configuration is on trial.
    void show_trial(std::optional<ShownTrial> trial) { trial_ = trial; }
    /// Updates the rates. Call it a few times a second.
    void look();

    /// Readable when a client must be served.
    std::vector<int> descriptors() const;
    /// When `serve` must be called at the latest.
    Instant due() const;
    /// Serves all clients, without waiting.
    void serve(Instant now);
    /// True if somebody may read measurements of the machine.
    bool watched() const {
        return (control_ && control_->watched()) || (look_ && look_->watched());
    }
    /// Null if the daemon runs without a control socket.
    ControlServer* control() { return control_.get(); }
    /// For who may look but not change (`look_socket`). Null if the daemon runs without it.
    ControlServer* look_only() { return look_.get(); }
    /// The file from which a draft is read. Empty without a control socket.
    const std::string& draft() const { return draft_; }

  private:
    explicit DaemonSockets(Instant started) : started_(started) {}
    void open_look_socket(const std::string& control);
    void add_telling(ControlServer& server);
    std::string status();
    std::string metrics();
    std::string changes(std::span<const std::string> words) const;
    StatusReport report();
    std::string record(std::span<const std::string> words) const;
    std::string recordings() const;
    std::string histograms() const;

    Instant started_;
    const Appliance* appliance_ = nullptr;
    ChangeJournal* changes_ = nullptr;
    std::optional<StatusKeeper> keeper_;
    std::optional<ShownTrial> trial_;
    std::string fingerprint_;  ///< of the configuration that runs; empty until somebody asks
    std::string draft_;
    std::unique_ptr<ControlServer> control_;
    std::unique_ptr<ControlServer> look_;
};

}  // namespace tribus
