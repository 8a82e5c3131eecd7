#include "pipelines/rules/debouncer.h"

#include <gtest/gtest.h>

namespace tribus::test::debouncer_test {
namespace {

using namespace std::chrono_literals;

Instant at(Duration since_start) {
    return Instant(since_start);
}

/// A debouncer of 20 ms that has been inactive since the start.
Debouncer settled() {
    Debouncer contact(20ms);
    contact.look(false, false, at(0ms));
    return contact;
}

TEST(Debouncer, KnowsNothingBeforeTheFirstLook) {
    EXPECT_EQ(Debouncer(20ms).level(), std::nullopt);
    EXPECT_EQ(Debouncer(20ms).settles_at(), kNever);
}

TEST(Debouncer, BelievesTheFirstLevelAtOnce) {
    Debouncer contact(20ms);
    contact.look(true, false, at(0ms));
    EXPECT_EQ(contact.level(), true);
    EXPECT_EQ(contact.settles_at(), kNever);
}

TEST(Debouncer, BelievesANewLevelOnceItHasStoodStill) {
    Debouncer contact = settled();
    contact.look(true, true, at(100ms));
    EXPECT_EQ(contact.level(), false);
    EXPECT_EQ(contact.settles_at(), at(120ms));
    contact.look(true, false, at(120ms) - 1ns);
    EXPECT_EQ(contact.level(), false);
    contact.look(true, false, at(120ms));
    EXPECT_EQ(contact.level(), true);
    EXPECT_EQ(contact.settles_at(), kNever);
}

TEST(Debouncer, NoticesALevelWhoseEdgeItHasMissed) {
    Debouncer contact = settled();
    contact.look(true, false, at(100ms));
    contact.look(true, false, at(120ms));
    EXPECT_EQ(contact.level(), true);
}

TEST(Debouncer, StartsAnewAtEachBounceEvenIfItReadsTheSameLevel) {
    Debouncer contact = settled();
    contact.look(true, true, at(100ms));
    contact.look(true, true, at(115ms));
    EXPECT_EQ(contact.settles_at(), at(135ms));
    contact.look(true, false, at(134ms));
    EXPECT_EQ(contact.level(), false);
    contact.look(true, false, at(135ms));
    EXPECT_EQ(contact.level(), true);
}

TEST(Debouncer, ForgetsALevelThatDidNotLast) {
    Debouncer contact = settled();
    contact.look(true, true, at(100ms));
    contact.look(false, true, at(105ms));
    EXPECT_EQ(contact.settles_at(), kNever);
    contact.look(false, false, at(200ms));
    EXPECT_EQ(contact.level(), false);
}

TEST(Debouncer, SaysAtOnceThatALineCannotBeReadAndWhatItReadsAfterwards) {
    Debouncer contact = settled();
    contact.look(std::nullopt, false, at(100ms));
    EXPECT_EQ(contact.level(), std::nullopt);
    contact.look(true, true, at(101ms));
    EXPECT_EQ(contact.level(), true);
}

TEST(Debouncer, WithoutATimeBelievesEveryLevel) {
    Debouncer contact(0ms);
    contact.look(false, false, at(0ms));
    contact.look(true, true, at(1ms));
    EXPECT_EQ(contact.level(), true);
    contact.look(false, true, at(1ms));
    EXPECT_EQ(contact.level(), false);
}

}  // namespace
}  // namespace tribus::test::debouncer_test
