#include <sys/socket.h>

#include <array>
#include <chrono>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "app/client/control_socket.h"
#include "app/daemon/socket_server.h"
#include "tests/support/temporary_folder.h"

/// A server whose clients ask in lines, in virtual time.
namespace tribus::socket_server_test {
namespace {

using std::chrono::seconds;

class ServedSocket : public testing::Test {
  protected:
    ServedSocket() {
        auto listener = LocalListener::open(path_);
        const auto request = [this](SocketClient& client, Instant now) {
            const auto line = client.waits() ? std::nullopt : client.take_line();
            if (line == "late") {
                client.wait_for([this] { return late_answer_; });
            }
            auto late = client.waits() ? client.take_answer() : std::nullopt;
            return late             ? client.send(*std::move(late), now)
                   : line == "long" ? client.send(std::string(3'000'000, 'x'), now)
                                    : true;
        };
        server_.emplace(
            *SocketServer::make(std::move(listener->descriptor()),
                                {.clients = 4,
                                 .request = 64,
                                 .unread = seconds(10),
                                 .idle = seconds(5),
                                 .asking = seconds(10),
                                 .refusal = "full"},
                                {.request = request, .repeat = [](auto&, auto) { return true; }}));
        listener_.emplace(std::move(*listener));
    }
    UniqueFd client(const std::string& says) {
        auto socket = connect_local(path_);
        EXPECT_TRUE(socket);
        ::send(socket->get(), says.data(), says.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
        server_->serve(now_);
        return std::move(*socket);
    }
    std::size_t clients_at(Instant now) {
        server_->serve(now);
        return server_->client_count();
    }
    static std::string said_to(const UniqueFd& client) {
        std::array<char, 64> bytes{};
        const ssize_t count = ::recv(client.get(), bytes.data(), bytes.size(), MSG_DONTWAIT);
        return count > 0 ? std::string(bytes.data(), static_cast<std::size_t>(count)) : "";
    }

    Instant now_{std::chrono::hours(1)};
    std::optional<std::string> late_answer_;

  private:
    test::TemporaryFolder folder_;
    std::string path_ = folder_ / "socket";
    std::optional<LocalListener> listener_;
    std::optional<SocketServer> server_;
};

TEST_F(ServedSocket, DropsOneWhoAsksNothing) {
    const UniqueFd silent = client("");
    EXPECT_EQ(clients_at(now_ + seconds(4)), 1U);
    EXPECT_EQ(clients_at(now_ + seconds(5)), 0U);
}

TEST_F(ServedSocket, DropsOneWhoDoesNotRead) {
    const UniqueFd lazy = client("long\n");
    EXPECT_EQ(clients_at(now_ + seconds(9)), 1U);
    EXPECT_EQ(clients_at(now_ + seconds(10)), 0U);
}

TEST_F(ServedSocket, DropsOneWhoSendsAByteNowAndThen) {
    const UniqueFd endless = client("");
    for (int second = 0; second < 10; ++second) {
        ::send(endless.get(), "x", 1, MSG_NOSIGNAL);
        EXPECT_EQ(clients_at(now_ + seconds(second)), 1U);
    }
    EXPECT_EQ(clients_at(now_ + seconds(10)), 0U);
}

/// A reload takes as long as its devices take to open.
TEST_F(ServedSocket, KeepsOneWhoWaitsForItsAnswer) {
    const UniqueFd waiting = client("late\n");
    EXPECT_EQ(clients_at(now_ + seconds(30)), 1U);
    late_answer_ = "here";
    EXPECT_EQ(clients_at(now_ + seconds(31)), 1U);
    EXPECT_EQ(said_to(waiting), "here");
}

TEST_F(ServedSocket, AnswersBesideThirtyWhoAskSlowly) {
    std::vector<UniqueFd> slow;
    for (int i = 0; i < 30; ++i) {
        slow.push_back(client("lat"));
    }
    late_answer_ = "here";
    EXPECT_EQ(said_to(client("late\n")), "here");
}

}  // namespace
}  // namespace tribus::socket_server_test
