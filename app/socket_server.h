#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <string>
#include <utility>

#include <tl/expected.hpp>

#include "app/socket_client.h"
#include "core/time.h"
#include "transports/links/unique_fd.h"

namespace tribus {

/// How much those who connect may cost. Each has its reason in the figures of a small board: 16
/// clients that hold all they may are less than half a megabyte.
struct SocketLimits {
    std::size_t clients = 16;
    /// The longest request, in bytes.
    std::size_t request = 256;
    /// One that reads nothing of what it is sent for so long is dropped.
    Duration unread = std::chrono::seconds(10);
    /// One that asks nothing for so long, and is to get nothing, is dropped.
    Duration idle = std::chrono::seconds(60);
    /// One that is connected for so long is dropped.
    Duration whole = Duration::max();
    /// What one that is too many is told; may be empty.
    std::string refusal{};
};

/// Serves a listening socket without ever waiting: for one who connects, at most a request and an
/// answer are kept. Where all places are taken, one who waits for nothing gives way to one who
/// comes: of the user with the most places that one who has been quiet the longest. Thread-bound to
/// the main thread, which waits on `descriptor` until `due`, and calls `serve` then.
class SocketServer {
  public:
    /// What to say to a client. False: drop it.
    using Speech = std::function<bool(SocketClient&, Instant now)>;
    struct Answers {
        /// It is ready for an answer and may have a request, as `received` shows.
        Speech request;
        /// Its `due` has come.
        Speech repeat;
    };

    /// `listener` listens already and does not block.
    static tl::expected<SocketServer, std::string> make(UniqueFd listener, SocketLimits limits,
                                                        Answers answers);

    /// Readable when there is something to serve.
    int descriptor() const { return epoll_.get(); }
    Instant due() const;
    void serve(Instant now);
    std::size_t client_count() const { return clients_.size(); }
    /// Clients that were dropped because they did not read, or asked nothing.
    std::size_t dropped() const { return dropped_; }

  private:
    SocketServer(UniqueFd listener, UniqueFd epoll, SocketLimits limits, Answers answers)
        : listener_(std::move(listener)),
          epoll_(std::move(epoll)),
          limits_(std::move(limits)),
          answers_(std::move(answers)) {}
    void accept_all(Instant now);
    void refuse(UniqueFd client) const;
    bool make_room_for(std::uint32_t user);
    bool serve_client(SocketClient& client, Instant now);
    bool repeat(SocketClient& client, Instant now);
    Instant patience_end(const SocketClient& client) const;
    void watch(const SocketClient& client);

    UniqueFd listener_;
    UniqueFd epoll_;
    SocketLimits limits_;
    Answers answers_;
    std::list<SocketClient> clients_;
    /// No connection is accepted before then.
    Instant accept_again_{};
    bool accepting_ = true;
    std::size_t dropped_ = 0;
};

}  // namespace tribus
