#include "app/daemon/daemon_sockets.h"

#include <algorithm>

#include "app/changes/change_json.h"
#include "app/cli/object_text.h"
#include "app/client/control_socket.h"
#include "app/journal/log.h"
#include "app/status/fingerprint.h"
#include "app/status/histograms.h"
#include "app/status/status_json.h"
#include "config/show/effective.h"
#include "pipelines/realtime/clock.h"

namespace tribus {

tl::expected<std::unique_ptr<DaemonSockets>, std::string> DaemonSockets::open(
    const std::string& config, const std::optional<std::string>& socket) {
    std::unique_ptr<DaemonSockets> sockets(new DaemonSockets(monotonic_now()));
    const auto path =
        socket ? socket : default_socket(SocketDirectories::of_this_process(), config);
    if (!path) {
        log_info(
            "no control socket: neither RUNTIME_DIRECTORY nor XDG_RUNTIME_DIR is set; set its path "
            "with --socket");
        return sockets;
    }
    auto control = ControlServer::open(*path);
    if (!control && socket) {
        return tl::unexpected(control.error());
    }
    if (!control) {
        log_info("no control socket: {}", control.error());
        return sockets;
    }
    sockets->control_ = std::move(*control);
    sockets->draft_ = draft_file(*path);
    sockets->add_telling(*sockets->control_);
    sockets->control_->add("record",
                           [self = sockets.get()](auto words) { return self->record(words); });
    sockets->open_look_socket(*path);
    return sockets;
}

/// Without it the daemon runs all the same.
void DaemonSockets::open_look_socket(const std::string& control) {
    auto look = ControlServer::open(look_socket(control));
    if (!look) {
        log_info("no socket that only tells: {}", look.error());
        return;
    }
    look_ = std::move(*look);
    look_->tell_only(control);
    add_telling(*look_);
    look_->add("record", [this](auto words) {
        return words.empty() ? error_object(
                                   "\"record\" begins a recording, and this socket only "
                                   "tells; allowed here: \"record N\"")
                             : record(words);
    });
}

void DaemonSockets::add_telling(ControlServer& server) {
    server.add("status", [this](auto) { return status(); });
    server.add("changes", [this](auto words) { return changes(words); });
    server.add("metrics", [this](auto) { return metrics(); });
    server.add("recordings", [this](auto) { return recordings(); });
    server.add("histograms", [this](auto) { return histograms(); });
}

void DaemonSockets::show(const Appliance& appliance, ChangeJournal& changes) {
    appliance_ = &appliance;
    changes_ = &changes;
    keeper_.emplace(appliance, started_);
    fingerprint_.clear();
}

void DaemonSockets::look() {
    keeper_->look(*appliance_);
}

std::vector<int> DaemonSockets::descriptors() const {
    std::vector<int> descriptors;
    // One allocation at each wake-up; the main loop adds the descriptor of a reload.
    descriptors.reserve(3);
    for (const auto* server : {control_.get(), look_.get()}) {
        if (server != nullptr) {
            descriptors.push_back(server->descriptor());
        }
    }
    return descriptors;
}

Instant DaemonSockets::due() const {
    return std::min(control_ ? control_->due() : kNever, look_ ? look_->due() : kNever);
}

void DaemonSockets::serve(Instant now) {
    if (control_ && keeper_) {
        control_->serve(now);
    }
    if (look_ && keeper_) {
        look_->serve(now);
    }
}

StatusReport DaemonSockets::report() {
    const Instant now = monotonic_now();
    StatusReport report = keeper_->report(*appliance_, now, wall_time_now());
    // Whoever reads a status can ask for the changes that led to it.
    changes_->look(*appliance_, now, wall_time_now());
    report.changes = changes_->newest();
    report.fingerprint = fingerprint_;
    if (trial_) {
        report.trial_left = std::max(trial_->end - now, Duration::zero());
        report.trial = trial_->number;
    }
    return report;
}

std::string DaemonSockets::status() {
    if (!keeper_) {
        return error_object("nothing runs any more");
    }
    // The text of many pipelines takes memory that a daemon whom nobody asks does not need.
    if (fingerprint_.empty()) {
        fingerprint_ = fingerprint(effective_toml(appliance_->configuration()));
    }
    return status_json(report());
}

std::string DaemonSockets::changes(std::span<const std::string> words) const {
    return keeper_ ? changes_json(*changes_, words) : error_object("nothing runs any more");
}

std::string DaemonSockets::metrics() {
    return keeper_ ? metrics_json(report()) : error_object("nothing runs any more");
}

std::string DaemonSockets::record(std::span<const std::string> words) const {
    if (!keeper_) {
        return error_object("nothing runs any more");
    }
    FlightRecorder* recorder = appliance_->recorder();
    return recorder == nullptr
               ? error_object("the configuration has no [recorder]; add that table and reload")
               : recorder->answer(words, monotonic_now(), wall_time_now());
}

std::string DaemonSockets::recordings() const {
    return keeper_ ? recordings_json(appliance_->recorder())
                   : error_object("nothing runs any more");
}

std::string DaemonSockets::histograms() const {
    return keeper_ ? histograms_json(histograms_of(*appliance_, monotonic_now()))
                   : error_object("nothing runs any more");
}

}  // namespace tribus
