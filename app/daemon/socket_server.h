#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <string>
#include <utility>

#include <tl/expected.hpp>

#include "app/client/socket_client.h"
#include "core/time.h"
#include "transports/links/unique_fd.h"

namespace tribus {

/// Limits for the cost of clients, chosen for small boards: 16 clients with all that they may hold
/// take less than half a megabyte.
struct SocketLimits {
    std::size_t clients = 16;
    /// Upper limit of a request, in bytes.
    std::size_t request = 256;
    /// A client that reads nothing of an answer for so long is dropped.
    Duration unread = std::chrono::seconds(10);
    /// A client that requests nothing for so long, and does not watch, is dropped.
    Duration idle = std::chrono::seconds(60);
    /// A client whose request is not whole so long after its first byte is dropped.
    Duration asking = Duration::max();
    /// Sent to clients for whom there is no place; may be empty.
    std::string refusal{};
};

/// Serves a listening socket without waiting. Keeps at most one request and one answer of each
/// client. If all places are taken, a client that waits for nothing gives way to a new one: of the
/// user or address with the most places, the one that was quiet longest. Thread-bound to the main
/// thread, which waits on `descriptor` until `due` and then calls `serve`.
class SocketServer {
  public:
    /// Answers a client. Returns false if the client must be dropped.
    using AnswerFunction = std::function<bool(SocketClient&, Instant now)>;
    struct Answers {
        /// Called when the client is ready for an answer; `received` may hold a request.
        AnswerFunction request;
        /// Called when the client's `due` has come.
        AnswerFunction repeat;
    };

    /// `listener` must listen already and be non-blocking.
    static tl::expected<SocketServer, std::string> make(UniqueFd listener, SocketLimits limits,
                                                        Answers answers);

    /// Readable when a client must be served.
    int descriptor() const { return epoll_.get(); }
    /// When `serve` must be called at the latest.
    Instant due() const;
    /// Accepts, reads, answers and drops clients, as far as possible without waiting.
    void serve(Instant now);
    std::size_t client_count() const { return clients_.size(); }
    /// Clients that were dropped because they did not read or requested nothing.
    std::size_t dropped() const { return dropped_; }

  private:
    SocketServer(UniqueFd listener, UniqueFd epoll, SocketLimits limits, Answers answers)
        : listener_(std::move(listener)),
          epoll_(std::move(epoll)),
          limits_(std::move(limits)),
          answers_(std::move(answers)) {}
    void accept_all(Instant now);
    void refuse(UniqueFd client) const;
    bool make_room_for(const std::string& who);
    bool serve_client(SocketClient& client, Instant now);
    bool repeat(SocketClient& client, Instant now);
    Instant patience_end(const SocketClient& client) const;
    void watch(const SocketClient& client);

    UniqueFd listener_;
    UniqueFd epoll_;
    SocketLimits limits_;
    Answers answers_;
    std::list<SocketClient> clients_;
    /// No connection is accepted before this instant.
    Instant accept_again_{};
    bool accepting_ = true;
    std::size_t dropped_ = 0;
};

}  // namespace tribus
