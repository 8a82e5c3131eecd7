#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "app/client/change_reader.h"
#include "app/client/control_socket.h"
#include "app/client/monitor_link.h"
#include "app/mqtt/discovery.h"
#include "app/mqtt/outbox.h"
#include "core/time.h"

namespace tribus::mqtt {

struct BoardOptions {
    std::string board;
    std::string prefix = "tribus";
    /// Home Assistant's prefix; empty: no discovery.
    std::string discovery = "homeassistant";
    std::string version;
};

/// Watches all daemons of this board by their sockets that tell, and puts what is to be told into
/// the outbox. Thread-bound; nothing here waits.
class BoardWatch {
  public:
    BoardWatch(BoardOptions options, Outbox& outbox);

    /// The daemons that run now; those that ended are still watched.
    void look_for_daemons(const std::vector<FoundSocket>& sockets, Instant now);
    /// Takes what arrived. `wall_time`: of the board's clock.
    void look(Instant now, std::chrono::microseconds wall_time);

    /// Readable when something has arrived.
    std::vector<int> descriptors() const;
    std::size_t size() const { return daemons_.size(); }

    /// A daemon that says nothing for so long hangs.
    static constexpr Duration kHangs = std::chrono::seconds(2);
    /// The status is told this often, and at each change.
    static constexpr Duration kTellPeriod = std::chrono::seconds(1);

  private:
    enum class Presence : std::uint8_t { unknown, here, gone, silent, old_figures };

    struct Daemon {
        MonitorLink link;
        DaemonTopics topics;
        std::string discovery_topic;
        Presence presence = Presence::unknown;
        ChangeReader changes{};
        std::optional<nlohmann::json> newest{};
        Instant received{};
        Instant told{};
    };

    void take(Daemon& daemon, const std::string& line, Instant now);
    void take_status(Daemon& daemon, nlohmann::json status, Instant now);
    void take_changes(Daemon& daemon, const nlohmann::json& answer, Instant now);
    void tell_status(Daemon& daemon, Instant now);
    void become(Daemon& daemon, Presence presence, Instant now,
                std::chrono::microseconds wall_time);

    BoardOptions options_;
    Outbox& outbox_;
    std::map<std::string, Daemon> daemons_;
};

}  // namespace tribus::mqtt
