#include "app/daemon/daemon_sockets.h"

#include <algorithm>

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
    sockets->control_->add("status", [self = sockets.get()](auto) { return self->status(); });
    sockets->control_->add("metrics", [self = sockets.get()](auto) { return self->metrics(); });
    sockets->control_->add("record",
                           [self = sockets.get()](auto words) { return self->record(words); });
    sockets->control_->add("recordings",
                           [self = sockets.get()](auto) { return self->recordings(); });
    sockets->control_->add("histograms",
                           [self = sockets.get()](auto) { return self->histograms(); });
    return sockets;
}

void DaemonSockets::show(const Appliance& appliance) {
    appliance_ = &appliance;
    keeper_.emplace(appliance, started_);
    fingerprint_.clear();
}

void DaemonSockets::look() {
    keeper_->look(*appliance_);
}

std::vector<int> DaemonSockets::descriptors() const {
    std::vector<int> descriptors;
    if (control_) {
        descriptors.push_back(control_->descriptor());
    }
    return descriptors;
}

Instant DaemonSockets::due() const {
    return control_ ? control_->due() : kNever;
}

void DaemonSockets::serve(Instant now) {
    if (control_ && keeper_) {
        control_->serve(now);
    }
}

StatusReport DaemonSockets::report() const {
    const Instant now = monotonic_now();
    StatusReport report = keeper_->report(*appliance_, now, wall_time_now());
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

std::string DaemonSockets::metrics() const {
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
