#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "app/appliance.h"
#include "app/control_server.h"
#include "app/metrics_server.h"
#include "app/status.h"
#include "core/time.h"

namespace tribus {

/// What a running daemon shows of itself to those who ask. Thread-bound to the main thread, which
/// waits for `descriptors` and `due`; nothing here waits.
class InsideView {
  public:
    /// Makes the control socket of the daemon that runs `config`: at `socket`, or, where none is
    /// given, in the usual place. The error, a sentence, is about a given one; without a usual
    /// place, or where it is taken, the daemon runs without, and the log says so.
    static tl::expected<std::unique_ptr<InsideView>, std::string> open(
        const std::string& config, const std::optional<std::string>& socket);
    InsideView(const InsideView&) = delete;
    InsideView& operator=(const InsideView&) = delete;

    /// Tells metrics at `address` too, as `MetricsServer` does. The error is a sentence.
    tl::expected<void, std::string> tell_metrics(const std::string& address, MetricsReach reach);

    /// From now on it shows this one, which must outlive it or the next call.
    void show(const Appliance& appliance);
    /// Nothing runs any more.
    void hide() { keeper_.reset(); }
    /// Until when the configuration is on trial; nothing where it is not.
    void show_trial(std::optional<Instant> end) { trial_end_ = end; }
    /// Looks at what it shows; call a few times a second.
    void look();

    /// Readable when there is something to serve.
    std::vector<int> descriptors() const;
    Instant due() const;
    void serve(Instant now);
    bool watched() const { return metrics_ || (control_ && control_->watched()); }
    /// None where the daemon runs without.
    ControlServer* control() { return control_.get(); }

  private:
    explicit InsideView(Instant started) : started_(started) {}
    std::string status() const;
    StatusReport report() const;
    std::string record(std::span<const std::string> words) const;

    Instant started_;
    const Appliance* appliance_ = nullptr;
    std::optional<StatusKeeper> keeper_;
    std::optional<Instant> trial_end_;
    std::unique_ptr<ControlServer> control_;
    std::unique_ptr<MetricsServer> metrics_;
};

}  // namespace tribus
