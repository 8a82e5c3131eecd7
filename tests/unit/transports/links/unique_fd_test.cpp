#include "transports/links/unique_fd.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <utility>

namespace tribus::unique_fd_test {
namespace {

bool open_now(int fd) {
    return ::fcntl(fd, F_GETFD) != -1;
}

int some_descriptor() {
    return ::open("/dev/null", O_RDONLY | O_CLOEXEC);
}

TEST(UniqueFdTest, ClosesAtItsEnd) {
    const int fd = some_descriptor();
    ASSERT_TRUE(open_now(fd));
    { const UniqueFd owner(fd); }
    EXPECT_FALSE(open_now(fd));
}

TEST(UniqueFdTest, HandsOverWithAMove) {
    UniqueFd first(some_descriptor());
    const int fd = first.get();
    const UniqueFd second(std::move(first));
    EXPECT_EQ(second.get(), fd);
    EXPECT_TRUE(open_now(fd));
    EXPECT_EQ(first.get(), -1);  // NOLINT(bugprone-use-after-move)
}

TEST(UniqueFdTest, ClosesItsOwnWhenItTakesOverAnother) {
    UniqueFd keeper(some_descriptor());
    UniqueFd other(some_descriptor());
    const int closed = keeper.get();
    const int kept = other.get();
    keeper = std::move(other);
    EXPECT_FALSE(open_now(closed));
    EXPECT_TRUE(open_now(kept));
    EXPECT_EQ(keeper.get(), kept);
    EXPECT_EQ(other.get(), -1);  // NOLINT(bugprone-use-after-move)
}

TEST(UniqueFdTest, OwnsNothingUnlessGiven) {
    EXPECT_FALSE(UniqueFd().valid());
    EXPECT_EQ(UniqueFd().get(), -1);
}

TEST(UniqueFdTest, KeepsItsOwnWhereItIsMovedToItself) {
    UniqueFd owner(some_descriptor());
    UniqueFd& same = owner;
    owner = std::move(same);
    EXPECT_TRUE(open_now(owner.get()));
}

/// In a process of its own, which has no use for its standard input.
TEST(UniqueFdTest, OwnsStandardInputTooIfGiven) {
    EXPECT_EXIT(
        {
            ::dup2(some_descriptor(), 0);
            UniqueFd owner(0);
            const bool valid = owner.valid();
            owner.reset();
            std::_Exit(valid && !open_now(0) ? 0 : 1);
        },
        ::testing::ExitedWithCode(0), "");
}

}  // namespace
}  // namespace tribus::unique_fd_test
