#pragma once

#include <poll.h>

#include <chrono>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "app/client/control_socket.h"
#include "app/daemon/socket_server.h"
#include "tests/loopback/machine/guest.h"
#include "tests/support/temporary_folder.h"

namespace tribus::test {

/// Requests are lines: `late` waits for an answer, `long` gets more than a socket holds, `repeat`
/// gets a dot each 3 s, `bye` ends the connection behind a long answer, `drop` is no request.
class ServedTurns : public testing::Test {
  protected:
    explicit ServedTurns(std::size_t clients = 4, std::string refusal = "full") {
        auto listener = LocalListener::open(path_);
        EXPECT_TRUE(listener) << listener.error();
        auto server = SocketServer::make(
            std::move(listener->descriptor()),
            {.clients = clients,
             .request = 64,
             .unread = std::chrono::seconds(10),
             .idle = std::chrono::seconds(5),
             .asking = std::chrono::seconds(4),
             .refusal = std::move(refusal)},
            {.request = [this](SocketClient& client, Instant now) { return answer(client, now); },
             .repeat = [this](SocketClient& client,
                              Instant now) { return keeps_ && client.send(".", now); }});
        EXPECT_TRUE(server) << server.error();
        server_.emplace(std::move(*server));
        listener_.emplace(std::move(*listener));
    }
    bool answer(SocketClient& client, Instant now) {
        if (client.waits()) {
            auto late = client.take_answer();
            return !late || client.send(*std::move(late), now);
        }
        const auto line = client.take_line();
        if (line == "late") {
            client.wait_for([this] { return late_answer_; });
        } else if (line == "long") {
            return client.send(long_, now);
        } else if (line == "bye") {
            client.close_when_sent();
            return client.send(long_, now);
        } else if (line == "repeat") {
            constexpr Duration kPeriod = std::chrono::seconds(3);
            client.repeat(kPeriod, now + kPeriod);
        }
        return line != "drop";
    }
    /// Serves once, so much later.
    void serve(Duration time = Duration::zero()) {
        now_ += time;
        server_->serve(now_);
    }
    Guest guest(const std::string& says) {
        Guest guest(path_);
        guest.say(says);
        serve();
        return guest;
    }
    std::size_t count() const { return server_->client_count(); }
    Duration until_due() const { return server_->due() - now_; }
    bool calls() const {
        pollfd state{.fd = server_->descriptor(), .events = POLLIN, .revents = 0};
        return ::poll(&state, 1, 0) == 1;
    }

    TemporaryFolder folder_;
    const std::string path_ = folder_ / "socket";
    Instant now_{std::chrono::hours(1)};
    const std::string long_ = std::string(3'000'000, 'x');
    std::optional<std::string> late_answer_;
    bool keeps_ = true;
    std::optional<SocketServer> server_;

  private:
    std::optional<LocalListener> listener_;
};

}  // namespace tribus::test
