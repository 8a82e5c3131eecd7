#include "app/cli/screen_parts.h"

#include <gtest/gtest.h>

#include <chrono>

namespace tribus::test::screen_parts_test {
namespace {

using namespace std::chrono_literals;

TEST(ShortDuration, has_three_figures_at_most) {
    EXPECT_EQ(short_duration(34us), "34 us");
    EXPECT_EQ(short_duration(2400us), "2.4 ms");
    EXPECT_EQ(short_duration(98ms), "98 ms");
    EXPECT_EQ(short_duration(1250ms), "1.25 s");
}

}  // namespace
}  // namespace tribus::test::screen_parts_test
