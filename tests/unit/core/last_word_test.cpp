#include "core/last_word.h"

#include <gtest/gtest.h>

namespace tribus::last_word_test {
namespace {

using namespace std::chrono_literals;

TEST(LastWord, tells_each_change_while_the_limit_allows_it) {
    RateLimit limit(6, 30s);
    LastWord word(1);
    EXPECT_EQ(word.look(1, limit, Instant(0s)), std::nullopt);
    EXPECT_EQ(word.look(2, limit, Instant(1s)), 0U);
    EXPECT_EQ(word.look(2, limit, Instant(2s)), std::nullopt);
    EXPECT_EQ(word.look(1, limit, Instant(3s)), 0U);
}

TEST(LastWord, a_change_that_had_to_wait_is_told_as_soon_as_it_may) {
    RateLimit limit(1, 30s);
    LastWord word(1);
    EXPECT_EQ(word.look(2, limit, Instant(0s)), 0U);
    for (auto second = 1s; second < 30s; ++second) {
        EXPECT_EQ(word.look(3, limit, Instant(second)), std::nullopt);
    }
    EXPECT_EQ(word.said(), 2);
    EXPECT_EQ(word.look(3, limit, Instant(30s)), 0U) << "nothing but this one had to wait";
    EXPECT_EQ(word.said(), 3);
}

TEST(LastWord, a_change_that_was_undone_is_only_counted) {
    RateLimit limit(1, 30s);
    LastWord word(1);
    EXPECT_EQ(word.look(2, limit, Instant(0s)), 0U);
    EXPECT_EQ(word.look(3, limit, Instant(1s)), std::nullopt);
    EXPECT_EQ(word.look(2, limit, Instant(2s)), std::nullopt);
    EXPECT_EQ(word.look(2, limit, Instant(31s)), std::nullopt);
    EXPECT_EQ(word.look(1, limit, Instant(32s)), 2U) << "to 3 and back";
}

TEST(LastWord, what_is_known_already_needs_no_word) {
    RateLimit limit(6, 30s);
    LastWord word(1);
    word.take_as_known(2);
    EXPECT_EQ(word.look(2, limit, Instant(0s)), std::nullopt);
    EXPECT_EQ(word.look(1, limit, Instant(1s)), 0U);
}

TEST(LastWord, shares_its_limit_and_tells_what_others_had_swallowed) {
    RateLimit limit(1, 30s);
    LastWord word(1);
    EXPECT_EQ(limit.pass(Instant(0s)), 0U);
    EXPECT_EQ(limit.pass(Instant(1s)), std::nullopt);
    EXPECT_EQ(word.look(2, limit, Instant(2s)), std::nullopt);
    EXPECT_EQ(word.look(2, limit, Instant(30s)), 1U);
}

}  // namespace
}  // namespace tribus::last_word_test
