#include "app/client/socket_client.h"

#include <sys/socket.h>

#include <array>
#include <optional>
#include <string>
#include <utility>

#include <gtest/gtest.h>

namespace tribus::socket_client_test {
namespace {

const Instant kNow{std::chrono::seconds(1)};

class SourceOfAClient : public testing::Test {
  protected:
    SourceOfAClient() {
        std::array<int, 2> pair{};
        EXPECT_EQ(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, pair.data()),
                  0);
        client_.emplace(UniqueFd(pair[0]), 256, kNow);
        reader_ = UniqueFd(pair[1]);
    }
    std::string read() {
        std::string all;
        std::array<char, 65536> bytes;
        for (;;) {
            const ssize_t count = ::recv(reader_.get(), bytes.data(), bytes.size(), 0);
            if (count <= 0) {
                return all;
            }
            all.append(bytes.data(), static_cast<std::size_t>(count));
        }
    }

    std::optional<SocketClient> client_;
    UniqueFd reader_;
};

TEST_F(SourceOfAClient, ComesBehindTheTextPieceByPiece) {
    int pieces = 0;
    client_->follow_with([&]() -> std::optional<std::string> {
        ++pieces;
        return pieces > 2 ? "" : std::to_string(pieces);
    });
    EXPECT_TRUE(client_->send("head ", kNow));
    EXPECT_EQ(pieces, 0);
    EXPECT_FALSE(client_->ready()) << "no other answer may begin";
    EXPECT_TRUE(client_->flush(kNow));
    EXPECT_EQ(pieces, 1) << "one a turn, so that others have theirs";
    while (!client_->ready()) {
        ASSERT_TRUE(client_->flush(kNow));
    }
    EXPECT_EQ(read(), "head 12");
    EXPECT_TRUE(client_->flush(kNow));
    EXPECT_EQ(pieces, 3) << "it is not asked again";
}

TEST_F(SourceOfAClient, IsNotAskedWhileTheReaderStops) {
    int pieces = 0;
    client_->follow_with([&]() -> std::optional<std::string> {
        ++pieces;
        return std::string(100'000, 'x');
    });
    EXPECT_TRUE(client_->send("head ", kNow));
    for (int i = 0; i < 1000; ++i) {
        ASSERT_TRUE(client_->flush(kNow));
    }
    EXPECT_LT(pieces, 20);
    const int before = pieces;
    EXPECT_GT(read().size(), 100'000U);
    ASSERT_TRUE(client_->flush(kNow));
    ASSERT_TRUE(client_->flush(kNow));
    EXPECT_GT(pieces, before);
}

TEST_F(SourceOfAClient, ThatBreaksOffEndsTheClient) {
    client_->follow_with([]() -> std::optional<std::string> { return std::nullopt; });
    EXPECT_TRUE(client_->send("head ", kNow));
    EXPECT_FALSE(client_->flush(kNow));
}

}  // namespace
}  // namespace tribus::socket_client_test
