#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>
#include <tl/expected.hpp>

#include "app/control_socket.h"
#include "app/socket_server.h"
#include "core/time.h"

namespace tribus {

/// Answers those who ask the daemon over its local socket: a line of words in, an object of JSON
/// out, one a line. `watch [PERIOD]` repeats `status`, for as long as it is read; one who reads too
/// slowly misses objects and never gets an old one. Thread-bound to the main thread, which waits
/// for `descriptor` and `due` and then calls `serve`.
class ControlServer {
  public:
    /// The words behind the request's own in, one object without a line end out.
    using Command = std::function<std::string(std::span<const std::string> words)>;

    /// The error is a sentence.
    static tl::expected<std::unique_ptr<ControlServer>, std::string> open(const std::string& path);
    ControlServer(const ControlServer&) = delete;
    ControlServer& operator=(const ControlServer&) = delete;

    /// The same for what takes a while: its answer is asked for whenever something happens, until
    /// there is one.
    using LateAnswer = std::function<std::optional<std::string>()>;
    using LateCommand = std::function<LateAnswer(std::span<const std::string> words)>;

    /// What `name` does. `status` must be among them, for `watch`.
    void add(std::string name, Command command);
    void add_late(std::string name, LateCommand command);

    int descriptor() const { return server_->descriptor(); }
    Instant due() const { return server_->due(); }
    void serve(Instant now) { server_->serve(now); }
    /// Somebody is connected.
    bool watched() const { return server_->client_count() > 0; }
    const std::string& path() const { return listener_.path(); }

  private:
    explicit ControlServer(LocalListener listener) : listener_(std::move(listener)) {}
    bool answer(SocketClient& client, Instant now);
    std::string answer_line(SocketClient& client, const std::string& line, Instant now);
    std::string allowed() const;
    std::string watch(SocketClient& client, std::span<const std::string> words, Instant now);

    LocalListener listener_;
    std::optional<SocketServer> server_;
    std::map<std::string, Command, std::less<>> commands_;
    std::map<std::string, LateCommand, std::less<>> late_commands_;
};

/// On one line. File names and the like may be of any bytes; what is no UTF-8 is replaced.
std::string json_text(const nlohmann::ordered_json& json);

/// `{"error": text}`: an answer to what cannot be done.
std::string error_object(std::string_view text);

}  // namespace tribus
