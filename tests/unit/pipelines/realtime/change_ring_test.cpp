#include "pipelines/realtime/change_ring.h"

#include <atomic>
#include <cstdint>
#include <thread>

#include <gtest/gtest.h>

namespace tribus::test::change_ring_test {
namespace {

Change change_of(std::size_t index) {
    return {.at = Instant(Duration(index)), .index = index};
}

TEST(ChangeRing, HasNoChangeBeforeTheFirst) {
    const ChangeRing ring;
    EXPECT_EQ(ring.newest(), 0U);
    EXPECT_FALSE(ring.read(1));
}

TEST(ChangeRing, NumbersItsChangesFromOne) {
    ChangeRing ring;
    ring.add(change_of(7));
    ring.add(change_of(8));
    EXPECT_EQ(ring.newest(), 2U);
    EXPECT_EQ(ring.read(1)->index, 7U);
    EXPECT_EQ(ring.read(2)->index, 8U);
}

TEST(ChangeRing, SaysWhichChangesItNoLongerHas) {
    ChangeRing ring;
    for (std::size_t i = 1; i <= ChangeRing::kChanges + 1; ++i) {
        ring.add(change_of(i));
    }
    EXPECT_FALSE(ring.read(1));
    EXPECT_EQ(ring.read(2)->index, 2U);
    EXPECT_EQ(ring.read(ring.newest())->index, ChangeRing::kChanges + 1);
}

TEST(ChangeRing, GivesAReaderWholeChangesWhileItIsWritten) {
    constexpr std::uint64_t kChanges = 200'000;
    ChangeRing ring;
    std::atomic<bool> done{false};
    std::thread writer([&] {
        for (std::size_t i = 1; i <= kChanges; ++i) {
            ring.add(change_of(i));
        }
        done = true;
    });
    std::uint64_t read = 0;
    bool whole = true;
    while (!done || read < ring.newest()) {
        const std::uint64_t newest = ring.newest();
        for (std::uint64_t number = read + 1; number <= newest; ++number) {
            const auto change = ring.read(number);
            whole = whole && (!change ||
                              (change->index == number && change->at == Instant(Duration(number))));
        }
        read = newest;
    }
    writer.join();
    EXPECT_TRUE(whole);
    EXPECT_EQ(read, kChanges);
}

}  // namespace
}  // namespace tribus::test::change_ring_test
