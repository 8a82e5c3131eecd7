#include "pipelines/rules/debouncer.h"

#include <optional>

#include <gtest/gtest.h>

namespace tribus::test::debouncer_test {
namespace {

using namespace std::chrono_literals;

Instant at(Duration since_start) {
    return Instant(since_start);
}

constexpr std::optional<Instant> kNoEdge{};

/// A debouncer of 20 ms that has been inactive since the start.
Debouncer settled() {
    Debouncer contact(20ms);
    contact.look(false, kNoEdge, at(0ms));
    return contact;
}

TEST(Debouncer, KnowsNothingBeforeTheFirstLook) {
    EXPECT_EQ(Debouncer(20ms).level(), std::nullopt);
    EXPECT_EQ(Debouncer(20ms).settles_at(), kNever);
}

TEST(Debouncer, BelievesTheFirstLevelAtOnce) {
    Debouncer contact(20ms);
    contact.look(true, kNoEdge, at(0ms));
    EXPECT_EQ(contact.level(), true);
    EXPECT_EQ(contact.settles_at(), kNever);
}

TEST(Debouncer, BelievesANewLevelOnceItHasStoodStill) {
    Debouncer contact = settled();
    contact.look(true, at(100ms), at(100ms));
    EXPECT_EQ(contact.level(), false);
    EXPECT_EQ(contact.settles_at(), at(120ms));
    contact.look(true, kNoEdge, at(120ms) - 1ns);
    EXPECT_EQ(contact.level(), false);
    contact.look(true, kNoEdge, at(120ms));
    EXPECT_EQ(contact.level(), true);
    EXPECT_EQ(contact.settles_at(), kNever);
}

TEST(Debouncer, NoticesALevelWhoseEdgeItHasMissed) {
    Debouncer contact = settled();
    contact.look(true, kNoEdge, at(100ms));
    contact.look(true, kNoEdge, at(120ms));
    EXPECT_EQ(contact.level(), true);
}

TEST(Debouncer, StartsAnewAtEachBounceEvenIfItReadsTheSameLevel) {
    Debouncer contact = settled();
    contact.look(true, at(100ms), at(100ms));
    contact.look(true, at(115ms), at(115ms));
    EXPECT_EQ(contact.settles_at(), at(135ms));
    contact.look(true, kNoEdge, at(134ms));
    EXPECT_EQ(contact.level(), false);
    contact.look(true, kNoEdge, at(135ms));
    EXPECT_EQ(contact.level(), true);
}

TEST(Debouncer, ForgetsALevelThatDidNotLast) {
    Debouncer contact = settled();
    contact.look(true, at(100ms), at(100ms));
    contact.look(false, at(105ms), at(105ms));
    EXPECT_EQ(contact.settles_at(), kNever);
    contact.look(false, kNoEdge, at(200ms));
    EXPECT_EQ(contact.level(), false);
}

TEST(Debouncer, SaysAtOnceThatALineCannotBeReadAndWhatItReadsAfterwards) {
    Debouncer contact = settled();
    contact.look(std::nullopt, kNoEdge, at(100ms));
    EXPECT_EQ(contact.level(), std::nullopt);
    contact.look(true, at(101ms), at(101ms));
    EXPECT_EQ(contact.level(), true);
}

TEST(Debouncer, CountsFromTheLatestEdgeAlsoIfItIsToldLater) {
    Debouncer contact = settled();
    contact.look(true, at(100ms), at(100ms));
    contact.look(true, at(105ms), at(120ms));
    EXPECT_EQ(contact.level(), false);
    EXPECT_EQ(contact.settles_at(), at(125ms));
    contact.look(true, kNoEdge, at(125ms));
    EXPECT_EQ(contact.level(), true);
}

TEST(Debouncer, BelievesALevelWhoseLatestEdgeIsLongAgo) {
    Debouncer contact = settled();
    contact.look(true, at(100ms), at(121ms));
    EXPECT_EQ(contact.level(), true);
}

TEST(Debouncer, LetsTheLineRestAfterAnEdge) {
    Debouncer contact = settled();
    contact.look(true, at(100ms), at(100ms));
    EXPECT_EQ(contact.rests_until(), at(120ms));
    // The level did not last, but there was an edge.
    contact.look(false, at(115ms), at(120ms));
    EXPECT_EQ(contact.rests_until(), at(135ms));
    EXPECT_EQ(contact.settles_at(), kNever);
}

TEST(Debouncer, LetsTheLineRestForAtLeastAMillisecond) {
    Debouncer contact(0ms);
    contact.look(true, at(100ms), at(100ms));
    EXPECT_EQ(contact.rests_until(), at(101ms));
    Debouncer slow = settled();
    slow.look(true, at(100ms), at(119ms) + 500us);
    EXPECT_EQ(slow.rests_until(), at(120ms) + 500us);
    EXPECT_EQ(slow.settles_at(), slow.rests_until());
}

TEST(Debouncer, WithoutATimeBelievesEveryLevel) {
    Debouncer contact(0ms);
    contact.look(false, kNoEdge, at(0ms));
    contact.look(true, at(1ms), at(1ms));
    EXPECT_EQ(contact.level(), true);
    contact.look(false, at(1ms), at(1ms));
    EXPECT_EQ(contact.level(), false);
}

}  // namespace
}  // namespace tribus::test::debouncer_test
