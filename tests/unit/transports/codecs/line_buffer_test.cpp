#include "transports/codecs/line_buffer.h"

#include <gtest/gtest.h>

#include "tests/support/streams.h"

namespace tribus::line_buffer_test {
namespace {

using test::Bytes;

Bytes visible(const LineBuffer& buffer) {
    const auto view = buffer.view(0, buffer.size());
    return {view.begin(), view.end()};
}

TEST(LineBuffer, StartsEmptyAtTheStartOfTheStream) {
    const LineBuffer buffer;
    EXPECT_EQ(buffer.size(), 0U);
    EXPECT_EQ(buffer.first_position(), 0U);
}

TEST(LineBuffer, ShowsNoMoreThanAskedFor) {
    LineBuffer buffer;
    const Bytes read{1, 2, 3, 4, 5};
    buffer.open(read);
    EXPECT_TRUE(buffer.see(2));
    EXPECT_EQ(visible(buffer), (Bytes{1, 2}));
    EXPECT_TRUE(buffer.see(4));
    EXPECT_EQ(visible(buffer), (Bytes{1, 2, 3, 4}));
}

TEST(LineBuffer, ShowsAllOfAReadThatEndsBefore) {
    LineBuffer buffer;
    const Bytes read{1, 2, 3};
    buffer.open(read);
    EXPECT_FALSE(buffer.see(4));
    EXPECT_EQ(visible(buffer), read);
}

TEST(LineBuffer, DoesNotCopyWhatIsJudgedWithinARead) {
    LineBuffer buffer;
    const Bytes read{1, 2, 3};
    buffer.open(read);
    buffer.see(3);
    EXPECT_EQ(buffer.view(0, 3).data(), read.data());
}

TEST(LineBuffer, GivesBackWhatWasNotAskedFor) {
    LineBuffer buffer;
    const Bytes read{1, 2, 3, 4};
    buffer.open(read);
    buffer.see(3);
    buffer.drop(2);
    const auto rest = buffer.close();
    ASSERT_EQ(rest.size(), 1U);
    EXPECT_EQ(rest.front(), 4);
    EXPECT_EQ(visible(buffer), Bytes{3});
}

TEST(LineBuffer, KeepsWhatOutlastsTheRead) {
    LineBuffer buffer;
    Bytes read{1, 2};
    buffer.open(read);
    buffer.see(3);
    buffer.close();
    read.assign(2, 0);
    const Bytes next{3, 4};
    buffer.open(next);
    EXPECT_TRUE(buffer.see(4));
    EXPECT_EQ(visible(buffer), (Bytes{1, 2, 3, 4}));
}

TEST(LineBuffer, KeepsBytesUnseenOnlyWhileTheyAreFewerThanWanted) {
    LineBuffer buffer;
    const Bytes first{1};
    buffer.open(first);
    buffer.see(4);
    buffer.close();
    const Bytes more{2, 3, 4};
    std::span<const std::uint8_t> two = std::span(more).first(2);
    EXPECT_TRUE(buffer.keep(two));
    EXPECT_EQ(visible(buffer), (Bytes{1, 2, 3}));
    std::span<const std::uint8_t> last = std::span(more).last(1);
    EXPECT_FALSE(buffer.keep(last));
    EXPECT_EQ(visible(buffer), (Bytes{1, 2, 3}));
}

TEST(LineBuffer, AnEmptyOneWaitsForAByte) {
    LineBuffer buffer;
    std::span<const std::uint8_t> nothing;
    EXPECT_TRUE(buffer.keep(nothing));
    const Bytes one{1};
    std::span<const std::uint8_t> byte = one;
    EXPECT_FALSE(buffer.keep(byte));
}

TEST(LineBuffer, DroppingKeepsCountOfThePlaceInTheStream) {
    LineBuffer buffer;
    const Bytes read{1, 2, 3, 4};
    buffer.open(read);
    buffer.see(4);
    buffer.drop(3);
    EXPECT_EQ(visible(buffer), Bytes{4});
    EXPECT_EQ(buffer.first_position(), 3U);
}

TEST(LineBuffer, HoldsAllThatADecoderMayAskForWhereverItBegins) {
    LineBuffer buffer;
    const Bytes first(LineBuffer::kCapacity - 1, 7);
    buffer.open(first);
    buffer.see(LineBuffer::kCapacity);
    buffer.close();
    const Bytes long_read(1000, 8);
    buffer.open(long_read);
    for (std::size_t dropped = 0; dropped < 900; ++dropped) {
        ASSERT_TRUE(buffer.see(LineBuffer::kCapacity));
        buffer.drop(1);
    }
    EXPECT_EQ(buffer.first_position(), 900U);
    EXPECT_EQ(visible(buffer), Bytes(LineBuffer::kCapacity - 1, 8));
}

TEST(LineBuffer, ADamagedByteHasAPlaceAndAMark) {
    LineBuffer buffer;
    const Bytes one{1};
    buffer.open(one);
    buffer.see(3);
    buffer.close();
    buffer.append_damaged();
    const Bytes three{3};
    buffer.open(three);
    buffer.see(3);
    EXPECT_EQ(buffer.size(), 3U);
    EXPECT_FALSE(buffer.damaged(0));
    EXPECT_TRUE(buffer.damaged(1));
    EXPECT_FALSE(buffer.damaged(2));
    EXPECT_FALSE(buffer.damaged(0, 1));
    EXPECT_TRUE(buffer.damaged(0, 3));
    buffer.drop(1);
    EXPECT_TRUE(buffer.damaged(0));
    buffer.drop(1);
    EXPECT_FALSE(buffer.damaged(0));
}

TEST(LineBuffer, ADamagedByteIsWorthALook) {
    LineBuffer buffer;
    const Bytes one{1};
    buffer.open(one);
    buffer.see(30);
    buffer.close();
    buffer.append_damaged();
    std::span<const std::uint8_t> nothing;
    EXPECT_FALSE(buffer.keep(nothing));
}

TEST(LineBuffer, ADamagedByteThatDecidesNothingIsWaitedOut) {
    LineBuffer buffer;
    const Bytes one{1};
    buffer.open(one);
    buffer.see(3);
    buffer.close();
    buffer.append_damaged(false);
    std::span<const std::uint8_t> nothing;
    EXPECT_TRUE(buffer.keep(nothing));
    EXPECT_FALSE(buffer.keep(one));
}

TEST(LineBuffer, WhatIsKeptIsJudgedTogetherWithTheReadBehindIt) {
    LineBuffer buffer;
    buffer.keep_one(1, 1);
    buffer.append_damaged();
    const Bytes read{3, 4, 5};
    const auto joined = buffer.join(read, 2);
    EXPECT_EQ(Bytes(joined.begin(), joined.end()), (Bytes{1, 0, 3, 4}));
    buffer.hold(joined.subspan(1), 1, 5);
    EXPECT_EQ(visible(buffer), (Bytes{0, 3, 4}));
    EXPECT_TRUE(buffer.damaged(0));
    EXPECT_EQ(buffer.first_position(), 1U);
    std::span<const std::uint8_t> rest = read;
    buffer.pass(4, rest);
    EXPECT_EQ(rest.size(), 2U);
    EXPECT_EQ(buffer.size(), 0U);
    EXPECT_FALSE(buffer.any_damaged());
}

}  // namespace
}  // namespace tribus::line_buffer_test
