#include "transports/links/unique_fd.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

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
}

TEST(UniqueFdTest, ClosesItsOwnWhenItTakesOverAnother) {
    UniqueFd keeper(some_descriptor());
    UniqueFd other(some_descriptor());
    const int closed = keeper.get();
    const int kept = other.get();
    keeper = std::move(other);
    EXPECT_FALSE(open_now(closed));
    EXPECT_TRUE(open_now(kept));
}

TEST(UniqueFdTest, OwnsNothingUnlessGiven) {
    EXPECT_FALSE(UniqueFd().valid());
}

}  // namespace
}  // namespace tribus::unique_fd_test
