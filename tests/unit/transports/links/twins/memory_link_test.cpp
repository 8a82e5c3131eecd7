#include "transports/links/twins/memory_link.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

namespace tribus::memory_link_test {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes bytes_of(std::span<const std::uint8_t> view) {
    return {view.begin(), view.end()};
}

/// Returns 0, 1, 2 and so on, with 0 after 255.
Bytes counting(std::size_t count) {
    Bytes bytes(count);
    std::iota(bytes.begin(), bytes.end(), std::uint8_t{0});
    return bytes;
}

TEST(MemoryLinkTest, ReadsWhatTheFarSideSent) {
    MemoryLink link;
    link.send(Bytes{0x20, 0x40});
    Reception reception;
    EXPECT_EQ(link.read(reception), ReadStatus::received);
    EXPECT_EQ(bytes_of(reception.view()), (Bytes{0x20, 0x40}));
    EXPECT_TRUE(reception.damaged.none());
}

TEST(MemoryLinkTest, HasNothingWhenAllIsRead) {
    MemoryLink link;
    link.send(Bytes{0x20});
    Reception reception;
    link.read(reception);
    EXPECT_EQ(link.read(reception), ReadStatus::nothing);
    EXPECT_EQ(reception.count, 0U);
}

TEST(MemoryLinkTest, HasNothingAtFirst) {
    MemoryLink link;
    Reception reception;
    reception.count = 9;
    reception.full = true;
    reception.damaged.set();
    EXPECT_EQ(link.read(reception), ReadStatus::nothing);
    EXPECT_EQ(reception.count, 0U);
    EXPECT_FALSE(reception.full || reception.damaged.any());
    EXPECT_TRUE(link.written().empty());
    EXPECT_EQ(link.frames_written(), 0U);
}

TEST(MemoryLinkTest, GivesASingleByte) {
    MemoryLink link;
    EXPECT_EQ(link.send(Bytes{0x20}), 1U);
    Reception reception;
    EXPECT_EQ(link.read(reception), ReadStatus::received);
    EXPECT_EQ(bytes_of(reception.view()), Bytes{0x20});
}

TEST(MemoryLinkTest, SaysThatAFullReadMayLeaveMore) {
    MemoryLink link;
    Reception reception;
    link.send(Bytes(kBytesPerRead));
    link.read(reception);
    EXPECT_TRUE(reception.full);
    link.send(Bytes(kBytesPerRead - 1));
    link.read(reception);
    EXPECT_FALSE(reception.full);
}

TEST(MemoryLinkTest, DiscardsWhatWaits) {
    MemoryLink link;
    link.send(Bytes{1, 2});
    link.discard_unread();
    Reception reception;
    EXPECT_EQ(link.read(reception), ReadStatus::nothing);
    link.send(Bytes{3});
    link.read(reception);
    EXPECT_EQ(bytes_of(reception.view()), Bytes{3});
}

/// What a link is unless it says otherwise.
TEST(MemoryLinkTest, HasNoDescriptorAndNoThread) {
    MemoryLink link;
    EXPECT_EQ(link.descriptor(), -1);
    EXPECT_EQ(link.second_descriptor(), -1);
    EXPECT_FALSE(link.wakes_at_each_arrival());
    EXPECT_FALSE(link.stands(Instant::max()));
    EXPECT_TRUE(link.has_unread());
    EXPECT_EQ(link.ask(), WriteStatus::written);
    EXPECT_EQ(link.write_asked(Bytes{1}, {}), WriteStatus::written);
    EXPECT_EQ(bytes_of(link.written()), Bytes{1});
    EXPECT_EQ(link.as_bytes(), &link);
    EXPECT_EQ(link.as_can(), nullptr);
}

TEST(MemoryLinkTest, MarksTheDamagedByteOnly) {
    MemoryLink link;
    link.send(Bytes{1});
    EXPECT_TRUE(link.send_damaged(2));
    link.send(Bytes{3});
    Reception reception;
    link.read(reception);
    EXPECT_EQ(bytes_of(reception.view()), (Bytes{1, 2, 3}));
    EXPECT_EQ(reception.damaged.to_ullong(), 0b010U);
}

TEST(MemoryLinkTest, KeepsTheMarksOfAReceptionThatIsSent) {
    Reception sent;
    sent.bytes[0] = 7;
    sent.bytes[1] = 8;
    sent.count = 2;
    sent.damaged.set(1);
    MemoryLink link;
    EXPECT_EQ(link.send(sent), 2U);
    Reception reception;
    link.read(reception);
    EXPECT_EQ(bytes_of(reception.view()), (Bytes{7, 8}));
    EXPECT_EQ(reception.damaged.to_ullong(), 0b10U);
}

TEST(MemoryLinkTest, ReadsNoMoreThanOneWakeAndThenTheRest) {
    MemoryLink link;
    link.send(counting(kBytesPerRead + 1));
    Reception reception;
    link.read(reception);
    EXPECT_EQ(bytes_of(reception.view()), counting(kBytesPerRead));
    link.read(reception);
    EXPECT_EQ(bytes_of(reception.view()), Bytes{0});
}

TEST(MemoryLinkTest, KeepsTheOrderOverManyTimesItsCapacity) {
    MemoryLink link;
    std::uint8_t next_sent = 0;
    std::uint8_t next_read = 0;
    for (std::size_t round = 0; round < 3 * MemoryLink::kCapacity / 100; ++round) {
        Bytes bytes(100);
        std::iota(bytes.begin(), bytes.end(), next_sent);
        next_sent = static_cast<std::uint8_t>(next_sent + 100);
        ASSERT_EQ(link.send(bytes), 100U);
        Reception reception;
        link.read(reception);
        for (const std::uint8_t byte : reception.view()) {
            ASSERT_EQ(byte, next_read++);
        }
    }
}

TEST(MemoryLinkTest, TakesNoMoreThanItsCapacity) {
    MemoryLink link;
    EXPECT_EQ(link.send(Bytes(MemoryLink::kCapacity + 5)), MemoryLink::kCapacity);
    EXPECT_FALSE(link.send_damaged(0));
}

TEST(MemoryLinkTest, ShowsWhatWasWrittenUntilItIsCleared) {
    MemoryLink link;
    EXPECT_EQ(link.write(Bytes{1, 2}), WriteStatus::written);
    EXPECT_EQ(link.write(Bytes{3}), WriteStatus::written);
    EXPECT_EQ(bytes_of(link.written()), (Bytes{1, 2, 3}));
    EXPECT_EQ(link.frames_written(), 2U);
    link.clear_written();
    EXPECT_TRUE(link.written().empty());
    EXPECT_EQ(link.frames_written(), 0U);
}

TEST(MemoryLinkTest, RefusesAFrameThatDoesNotFitAsAWhole) {
    MemoryLink link;
    EXPECT_EQ(link.write(Bytes(MemoryLink::kCapacity - 1)), WriteStatus::written);
    EXPECT_EQ(link.write(Bytes(2)), WriteStatus::busy);
    EXPECT_EQ(link.written().size(), MemoryLink::kCapacity - 1);
    EXPECT_EQ(link.frames_written(), 1U);
    EXPECT_EQ(link.write(Bytes(1)), WriteStatus::written);
    EXPECT_EQ(link.write(Bytes(1)), WriteStatus::busy);
}

TEST(MemoryLinkTest, RefusesEveryFrameWhileBusy) {
    MemoryLink link;
    link.set_busy(true);
    EXPECT_EQ(link.write(Bytes{1}), WriteStatus::busy);
    EXPECT_TRUE(link.written().empty());
    link.set_busy(false);
    EXPECT_EQ(link.write(Bytes{1}), WriteStatus::written);
}

TEST(MemoryLinkTest, IsLostBothWaysAndTakesUnreadBytesWithIt) {
    MemoryLink link;
    link.send(Bytes{1});
    link.set_lost(true);
    Reception reception;
    reception.full = true;
    EXPECT_EQ(link.read(reception), ReadStatus::lost);
    EXPECT_EQ(reception.count, 0U);
    EXPECT_FALSE(reception.full);
    EXPECT_EQ(link.write(Bytes{1}), WriteStatus::lost);
    EXPECT_EQ(link.send(Bytes{2}), 0U);
    EXPECT_FALSE(link.send_damaged(2));
    link.set_lost(false);
    EXPECT_EQ(link.read(reception), ReadStatus::nothing);
    EXPECT_EQ(link.write(Bytes{1}), WriteStatus::written);
}

TEST(MemoryLinkTest, KeepsUnreadBytesWhileItIsThere) {
    MemoryLink link;
    link.send(Bytes{1});
    link.set_lost(false);
    Reception reception;
    EXPECT_EQ(link.read(reception), ReadStatus::received);
}

}  // namespace
}  // namespace tribus::memory_link_test
