#include "app/cli/streams.h"

#include <string>

#include <gtest/gtest.h>

namespace tribus::test::streams_test {
namespace {

TEST(InputWithoutAnEnd, IsReadUpToALimit) {
    const std::string told =
        "/dev/zero: more than 8 MiB, and no end; save it as a file and name that";
    EXPECT_EQ(InputFile::open_path("/dev/zero")->read_all(), tl::unexpected(told));
    const auto pieces = FilePieces::open_path("/dev/zero");
    ASSERT_FALSE(pieces);
    EXPECT_EQ(pieces.error(), told);
}

}  // namespace
}  // namespace tribus::test::streams_test
