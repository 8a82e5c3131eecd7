#include "transports/codecs/line_buffer.h"

#include <gtest/gtest.h>

#include "tests/support/streams.h"

namespace tribus {
namespace {

using test::Bytes;

TEST(LineBuffer, StartsEmptyAtTheStartOfTheStream) {
    const LineBuffer<4> buffer;
    EXPECT_EQ(buffer.size(), 0U);
    EXPECT_EQ(buffer.room(), 4U);
    EXPECT_EQ(buffer.first_position(), 0U);
}

TEST(LineBuffer, TakesNoMoreThanAskedAndNoMoreThanThereIs) {
    LineBuffer<8> buffer;
    const Bytes bytes{1, 2, 3};
    std::span<const std::uint8_t> rest = bytes;
    buffer.take(rest, 2);
    EXPECT_EQ(buffer.size(), 2U);
    EXPECT_EQ(rest.size(), 1U);
    buffer.take(rest, 5);
    EXPECT_EQ(buffer.size(), 3U);
    EXPECT_TRUE(rest.empty());
    EXPECT_EQ(buffer[2], 3);
}

TEST(LineBuffer, CanBeFilledToTheLastByteAndEmptied) {
    LineBuffer<3> buffer;
    buffer.append(Bytes{1, 2, 3});
    EXPECT_EQ(buffer.room(), 0U);
    buffer.drop(3);
    EXPECT_EQ(buffer.room(), 3U);
    EXPECT_EQ(buffer.first_position(), 3U);
}

TEST(LineBuffer, DroppingMovesTheRestToTheFrontAndKeepsCount) {
    LineBuffer<4> buffer;
    buffer.append(Bytes{1, 2, 3, 4});
    buffer.drop(2);
    buffer.append(Bytes{5});
    const auto view = buffer.view(0, 3);
    EXPECT_EQ(Bytes(view.begin(), view.end()), (Bytes{3, 4, 5}));
    EXPECT_EQ(buffer.first_position(), 2U);
}

TEST(LineBuffer, ADamagedByteHasAPlaceAndAMark) {
    LineBuffer<4> buffer;
    buffer.append(Bytes{1});
    buffer.append_damaged();
    buffer.append(Bytes{3});
    EXPECT_EQ(buffer.size(), 3U);
    EXPECT_FALSE(buffer.damaged(0));
    EXPECT_TRUE(buffer.damaged(1));
    EXPECT_FALSE(buffer.damaged(2));
    EXPECT_FALSE(buffer.damaged(0, 1));
    EXPECT_TRUE(buffer.damaged(0, 2));
    EXPECT_FALSE(buffer.damaged(2, 1));
}

TEST(LineBuffer, AMarkMovesWithItsByteAndGoesWithIt) {
    LineBuffer<4> buffer;
    buffer.append(Bytes{1, 2});
    buffer.append_damaged();
    buffer.drop(1);
    EXPECT_TRUE(buffer.damaged(1));
    buffer.drop(2);
    buffer.append(Bytes{7, 8, 9, 10});
    EXPECT_FALSE(buffer.damaged(0, 4));
}

}  // namespace
}  // namespace tribus
