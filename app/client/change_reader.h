#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace tribus {

/// Reads the changes of a daemon, each once and in their order, over the stream of its statuses: a
/// status says how many there were, and the request `changes` brings those that are new. How things
/// are at the first status is no change. Pure.
class ChangeReader {
  public:
    /// Whether one process says both statuses: it was started once.
    static bool same_process(const nlohmann::json& a, const nlohmann::json& b) {
        return same_start(start_of(a), start_of(b));
    }

    /// Takes a status of the daemon. Returns the request to send to it, if there is one.
    std::optional<std::string> take_status(const nlohmann::json& status);
    struct News {
        std::vector<nlohmann::json> changes;
        std::uint64_t lost = 0;  ///< came and went before this reader asked
        /// The next request to send, if more changes wait.
        std::optional<std::string> request;
    };
    /// Takes the answer to such a request.
    News take_answer(const nlohmann::json& answer);
    /// The connection is gone, and with it an answer that is on its way.
    void disconnected() { asked_ = false; }

  private:
    /// When the process that says this status was started, on the board's monotonic clock.
    static std::chrono::microseconds start_of(const nlohmann::json& status);
    static bool same_start(std::chrono::microseconds a, std::chrono::microseconds b);
    std::optional<std::string> ask(std::uint64_t newest);

    /// Number of the newest change that was read.
    std::optional<std::uint64_t> read_;
    std::chrono::microseconds start_{};  ///< of the process of the newest status
    bool asked_ = false;
};

}  // namespace tribus
