#pragma once

#include <string>
#include <utility>
#include <vector>

#include "core/time.h"
#include "transports/links/unique_fd.h"

namespace tribus {

/// Stream of status objects from a daemon, over its control socket. Reconnects by itself.
/// Thread-bound.
class MonitorLink {
  public:
    MonitorLink(std::string path, Duration period) : path_(std::move(path)), period_(period) {}

    /// True while there is a connection.
    bool connected() const { return descriptor_.valid(); }
    /// Readable when data has arrived; -1 while there is no connection.
    int descriptor() const { return descriptor_.get(); }
    /// Why there is no connection, as a sentence.
    const std::string& problem() const { return problem_; }
    /// Tries to connect if there is no connection and the last attempt is at least 500 ms ago.
    void reconnect(Instant now);
    /// Sends a request, whose answer comes among the objects. Without a connection it is lost.
    void send(const std::string& request);
    /// The complete lines received so far; does not wait.
    std::vector<std::string> read();

  private:
    void lose(std::string why);

    std::string path_;
    Duration period_;
    UniqueFd descriptor_;
    std::string received_;
    std::string problem_;
    Instant next_try_{};
};

}  // namespace tribus
