#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/appliance.h"
#include "app/log_limit.h"
#include "app/status_line.h"
#include "app/watchdog.h"
#include "core/change_report.h"
#include "core/rate_limit.h"
#include "core/time.h"
#include "transports/links/unique_fd.h"

namespace tribus {

/// The service manager's socket, as sd_notify(3) describes it: datagrams of NAME=VALUE lines to
/// $NOTIFY_SOCKET. Thread-bound to the main thread.
class NotifySocket {
  public:
    /// Without $NOTIFY_SOCKET, or where it cannot be reached, it says nothing.
    static NotifySocket from_environment();

    bool listens() const { return socket_.valid(); }
    /// Waits for a moment at most where the service manager is busy. True if it took the lines.
    bool say(std::string_view lines) const;

  private:
    UniqueFd socket_;
};

/// Tells a service manager what goes on: the start, reloads, the end, a line of status, and, only
/// while every output is on time, that its watchdog need not bite. Does nothing where no service
/// manager asks for it. Thread-bound to the main thread.
class ServiceNotify {
  public:
    ServiceNotify();

    /// The appliance runs: a first one, or a fresh one, or the old one after a refused reload.
    void started(const Appliance& appliance, Instant now);
    void reloading();
    void stopping();

    /// A few times a second.
    void look(const Appliance& appliance, Instant now);

  private:
    void look_at_outputs(const Appliance& appliance, Instant now);
    void tell_status(const Appliance& appliance, Instant now);

    NotifySocket socket_;
    /// None where the service manager has no watchdog.
    std::optional<Watchdog> watchdog_;
    ChangeReport<Punctuality> said_{Punctuality::on_time};
    RateLimit limit_ = log_limit();
    std::optional<StatusLine> status_;
    std::string told_;
    Instant next_status_{};
};

}  // namespace tribus
