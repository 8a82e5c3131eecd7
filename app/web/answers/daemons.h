#pragma once

#include <cstdint>
#include <filesystem>
#include <list>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/client/monitor_link.h"
#include "app/web/answers/line_talk.h"
#include "core/time.h"

/// The daemons of this board, as the page sees them: by their sockets, and by the
/// configurations that stand in the folder of configurations. Thread-bound; nothing here waits.
namespace tribus::web {

/// A daemon that runs, or a configuration that none runs.
struct KnownDaemon {
    std::string name;
    std::string tells;    ///< socket of a daemon for who only looks; empty: none runs
    std::string control;  ///< for who may change; empty: none runs, or it is not for this user
    std::filesystem::path file;
};

/// Those whose sockets this user may use, and the configurations in `folder`, ordered by name.
std::vector<KnownDaemon> known_daemons(const std::filesystem::path& folder);
/// The one with that name. Names are compared with the list and never become a path.
std::optional<KnownDaemon> find_known(const std::filesystem::path& folder, std::string_view name);

/// A daemon that is asked over its control socket.
LineTalk daemon_at(const std::string& socket);

/// One request, without waiting for its answer.
class LineRequest {
  public:
    LineRequest(LineTalk talk, std::string_view line, Instant end);

    int descriptor() const { return talk_.descriptor(); }
    Instant end() const { return end_; }
    /// Reads what is there. Returns the answer, or `{"type":"error","error":...,"unanswered":true}`
    /// that says why none comes; nothing while it may come.
    std::optional<std::string> poll(Instant now);

  private:
    LineTalk talk_;
    Instant end_;
};

/// The newest status of one daemon, while anybody looks.
class DaemonWatch {
  public:
    explicit DaemonWatch(const std::string& socket);

    int descriptor() const { return link_.descriptor(); }
    /// When `look` must be called at the latest.
    Instant due() const { return due_; }
    void look(Instant now);

    /// JSON in one line; empty before the first.
    const std::string& newest() const { return newest_; }
    /// Rises with each status.
    std::uint64_t number() const { return number_; }
    /// The newest status; empty while none comes, because that one would be old.
    std::string fresh(Instant now) const { return problem(now).empty() ? newest_ : std::string(); }
    /// Why no status comes; empty while they come.
    std::string problem(Instant now) const;

    /// As often as the data thread publishes.
    static constexpr Duration kPeriod = std::chrono::milliseconds(100);
    /// A daemon that says nothing for so long hangs.
    static constexpr Duration kHangs = std::chrono::milliseconds(500);

  private:
    MonitorLink link_;
    std::string newest_;
    std::uint64_t number_ = 0;
    Instant received_{};
    Instant due_{};
};

}  // namespace tribus::web
