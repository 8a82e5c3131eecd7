#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/appliance/appliance.h"
#include "app/daemon/watchdog.h"
#include "app/journal/log_limit.h"
#include "core/change_report.h"
#include "core/rate_limit.h"
#include "core/time.h"
#include "transports/links/unique_fd.h"

namespace tribus {

/// Socket of the service manager, see sd_notify(3): sends datagrams of NAME=VALUE lines to
/// $NOTIFY_SOCKET. Thread-bound to the main thread.
class NotifySocket {
  public:
    /// Without $NOTIFY_SOCKET, or if it cannot be reached, the object sends nothing.
    static NotifySocket from_environment();

    /// True if there is a service manager.
    bool connected() const { return socket_.valid(); }
    /// Sends the lines; waits at most 1 s if the service manager is busy. Returns true if it took
    /// them.
    bool send(std::string_view lines) const;

  private:
    UniqueFd socket_;
};

/// Notifies a service manager of the start, reloads and the end, with a line of status, and feeds
/// its watchdog while every output is on time. Does nothing without a service manager. Thread-bound
/// to the main thread.
class ServiceNotify {
  public:
    ServiceNotify();

    /// The appliance runs: the first one, a new one, or the old one after a refused reload.
    void started(Instant now);
    /// A reload begins; `started` ends it.
    void reloading();
    /// The program begins to end.
    void stopping();

    /// Call it a few times a second.
    void look(const Appliance& appliance, Instant now);

  private:
    void look_at_outputs(const Appliance& appliance, Instant now);
    void tell_status(const Appliance& appliance, Instant now);

    NotifySocket socket_;
    /// Empty if the service manager has no watchdog.
    std::optional<Watchdog> watchdog_;
    ChangeReport<Punctuality> reported_{Punctuality::on_time};
    RateLimit limit_ = log_limit();
    std::string sent_status_;
    Instant next_status_{};
};

}  // namespace tribus
