#include "pipelines/sensor_bus/echo_canceller.h"

#include <gtest/gtest.h>

#include <chrono>
#include <span>
#include <vector>

namespace tribus::echo_canceller_test {
namespace {

using namespace std::chrono_literals;
using Bytes = std::vector<std::uint8_t>;

constexpr Instant kNow{1s};
const Bytes kSent{0x06, 0xA1, 0x00, 0x00, 0x58, 0xFF};

Bytes after_cancelling(EchoCanceller& echo, const Bytes& heard, Instant now = kNow + 600us) {
    std::span<const std::uint8_t> bytes = heard;
    echo.cancel(bytes, now);
    return {bytes.begin(), bytes.end()};
}

TEST(EchoCanceller, LeavesWhatComesWithoutHavingBeenSent) {
    EchoCanceller echo;
    EXPECT_EQ(after_cancelling(echo, kSent), kSent);
}

TEST(EchoCanceller, TakesWhatWasSentAndLeavesWhatFollows) {
    EchoCanceller echo;
    echo.sent(kSent, kNow);
    Bytes heard = kSent;
    heard.push_back(0x04);
    EXPECT_EQ(after_cancelling(echo, heard), Bytes{0x04});
    EXPECT_EQ(echo.counts().returned, 1U);
}

TEST(EchoCanceller, TakesItInWhateverPiecesItComes) {
    for (std::size_t cut = 0; cut <= kSent.size(); ++cut) {
        EchoCanceller echo;
        echo.sent(kSent, kNow);
        const auto middle = kSent.begin() + static_cast<std::ptrdiff_t>(cut);
        EXPECT_TRUE(after_cancelling(echo, Bytes(kSent.begin(), middle)).empty());
        EXPECT_TRUE(after_cancelling(echo, Bytes(middle, kSent.end())).empty());
        EXPECT_EQ(echo.counts().returned, 1U) << cut;
    }
}

TEST(EchoCanceller, TakesAFrameThatIsTheSameAsItsRequestOnceOnly) {
    const Bytes discover{0x04, 0x81, 0x7A, 0xFF};
    EchoCanceller echo;
    echo.sent(discover, kNow);
    EXPECT_TRUE(after_cancelling(echo, discover).empty());
    EXPECT_EQ(after_cancelling(echo, discover), discover);
}

TEST(EchoCanceller, CountsADifferenceAsCollisionAndCancelsByCountAllTheSame) {
    for (std::size_t wrong = 0; wrong < kSent.size(); ++wrong) {
        EchoCanceller echo;
        echo.sent(kSent, kNow);
        Bytes heard = kSent;
        heard[wrong] ^= 0x10U;
        EXPECT_TRUE(after_cancelling(echo, heard).empty());
        EXPECT_EQ(echo.counts().collisions, 1U) << wrong;
        EXPECT_EQ(echo.counts().returned, 0U) << wrong;
    }
}

TEST(EchoCanceller, TakesADamagedByteForItsOwnWhileItsEchoIsOut) {
    EchoCanceller echo;
    EXPECT_FALSE(echo.cancel_damaged(kNow));
    echo.sent(kSent, kNow);
    EXPECT_TRUE(echo.cancel_damaged(kNow + 100us));
    EXPECT_TRUE(after_cancelling(echo, Bytes(kSent.begin() + 1, kSent.end())).empty());
    EXPECT_EQ(echo.counts().collisions, 1U);
}

TEST(EchoCanceller, NeverTakesTheNextRequestForALateEcho) {
    EchoCanceller echo;
    echo.sent(kSent, kNow);
    EXPECT_EQ(after_cancelling(echo, kSent, kNow + 4ms), kSent);
    EXPECT_EQ(echo.counts().missing, 1U);
}

TEST(EchoCanceller, CountsAnEchoThatLostAByteAsCollision) {
    EchoCanceller echo;
    echo.sent(kSent, kNow);
    EXPECT_TRUE(after_cancelling(echo, Bytes(kSent.begin(), kSent.end() - 1)).empty());
    echo.expire(kNow + 4ms);
    EXPECT_EQ(echo.counts().collisions, 1U);
}

TEST(EchoCanceller, HearsTheEchoBehindACollision) {
    EchoCanceller echo;
    echo.sent(kSent, kNow);
    Bytes spoilt = kSent;
    spoilt[3] ^= 0x01U;
    after_cancelling(echo, spoilt);
    echo.sent(kSent, kNow + 8ms);
    after_cancelling(echo, kSent, kNow + 9ms);
    EXPECT_EQ(echo.counts().collisions, 1U);
    EXPECT_EQ(echo.counts().returned, 1U);
}

}  // namespace
}  // namespace tribus::echo_canceller_test
