#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include <tl/expected.hpp>

#include "app/client/control_socket.h"
#include "app/daemon/socket_server.h"
#include "core/time.h"

namespace tribus {

/// Serves the control socket: a request is a line of words, an answer one JSON object on one line.
/// `watch [PERIOD]` repeats `status` while the client reads; a client that reads too slowly misses
/// objects but never gets an old one. Thread-bound to the main thread, which waits for `descriptor`
/// and `due` and then calls `serve`.
class ControlServer {
  public:
    /// Takes the words after the name of the request; returns one object without a line end.
    using Command = std::function<std::string(std::span<const std::string> words)>;

    /// Opens the socket at `path`. The error is a sentence.
    static tl::expected<std::unique_ptr<ControlServer>, std::string> open(const std::string& path);
    ControlServer(const ControlServer&) = delete;
    ControlServer& operator=(const ControlServer&) = delete;

    /// For requests that take time: `serve` calls the LateAnswer again and again until it returns
    /// the answer.
    using LateAnswer = std::function<std::optional<std::string>()>;
    using LateCommand = std::function<LateAnswer(std::span<const std::string> words)>;

    /// Other requests than those that are added change something: they are refused here, with the
    /// place where they are served.
    void tell_only(std::string control) { control_ = std::move(control); }

    /// Adds the request `name`. `watch` needs the request `status`.
    void add(std::string name, Command command);
    void add_late(std::string name, LateCommand command);

    int descriptor() const { return server_->descriptor(); }
    Instant due() const { return server_->due(); }
    void serve(Instant now) { server_->serve(now); }
    /// True if a client is connected.
    bool watched() const { return server_->client_count() > 0; }
    const std::string& path() const { return listener_.path(); }

  private:
    explicit ControlServer(LocalListener listener) : listener_(std::move(listener)) {}
    bool answer(SocketClient& client, Instant now);
    std::string answer_line(SocketClient& client, const std::string& line, Instant now);
    std::string allowed() const;
    std::string why_not(const std::string& request) const;
    std::string watch(SocketClient& client, std::span<const std::string> words, Instant now);

    LocalListener listener_;
    std::string control_;  ///< path of the control socket, if this one only tells
    std::optional<SocketServer> server_;
    std::map<std::string, Command, std::less<>> commands_;
    std::map<std::string, LateCommand, std::less<>> late_commands_;
};

}  // namespace tribus
