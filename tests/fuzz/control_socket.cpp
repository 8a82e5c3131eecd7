#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <memory>
#include <string>

#include "app/cli/object_text.h"
#include "app/daemon/control_server.h"
#include "tests/fuzz/fuzz.h"

namespace tribus::fuzz::control_socket_target {
namespace {

/// The socket of a daemon, with one client at a time.
class Served {
  public:
    Served() : path_("/tmp/tribus-fuzz-" + std::to_string(::getpid())) {
        auto opened = ControlServer::open(path_);
        require(opened.has_value(), "a control socket can be opened");
        control_ = std::move(*opened);
        control_->add("status", [](auto) { return R"({"type":"status"})"; });
        control_->add("reload", [](auto words) {
            return error_object(words.empty() ? "none" : words.front());
        });
    }

    /// Returns everything that the server sends to a client that sends this request and nothing
    /// more.
    std::string answers(std::span<const std::uint8_t> request) {
        auto client = connect_local(path_);
        require(client.has_value(), "a client can connect");
        [[maybe_unused]] const auto sent =
            ::send(client->get(), request.data(), request.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
        ::shutdown(client->get(), SHUT_WR);
        std::string said;
        for (int turn = 0; turn < kTurns; ++turn) {
            serve();
            if (!take(client->get(), said)) {
                break;
            }
        }
        client->reset();
        serve();
        require(!control_->watched(), "a client that has left is let go");
        return said;
    }

  private:
    /// More turns than any client has to wait for the next status.
    static constexpr int kTurns = 200;

    void serve() {
        now_ = later(now_, std::chrono::milliseconds(10));
        control_->serve(now_);
    }

    static bool take(int client, std::string& said) {
        std::array<char, 4096> bytes;
        for (;;) {
            const ssize_t count = ::recv(client, bytes.data(), bytes.size(), MSG_DONTWAIT);
            if (count <= 0) {
                return count < 0;
            }
            said.append(bytes.data(), static_cast<std::size_t>(count));
        }
    }

    std::string path_;
    std::unique_ptr<ControlServer> control_;
    Instant now_{};
};

}  // namespace

/// For any request the answers are whole objects, one a line, and the client is let go.
FUZZ_TARGET(control_socket) {
    static Served served;
    const std::string said = served.answers({data, size});
    require(said.empty() || said.back() == '\n', "an answer is a whole line");
    for (std::size_t begin = 0; begin < said.size();) {
        const std::size_t end = said.find('\n', begin);
        require(said[begin] == '{' && said[end - 1] == '}', "an answer is an object");
        begin = end + 1;
    }
    return 0;
}

}  // namespace tribus::fuzz::control_socket_target
