#include "transports/codecs/network/network.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "tests/support/channel_bytes.h"
#include "tests/support/streams.h"
#include "tests/unit/transports/codecs/authenticated/link_bench.h"
#include "transports/codecs/authenticated/fd_ends.h"
#include "transports/codecs/native_can/channels.h"

/// Snapshots in datagrams. Other programs computed the messages with a key.
namespace tribus::test::network_test {
namespace {

using namespace std::chrono_literals;

using authenticated_link::at;
using authenticated_link::sticks;

/// A message behind its head.
Bytes framed(std::string_view head, std::string_view message) {
    Bytes datagram = from_hex(head);
    append(datagram, from_hex(message));
    return datagram;
}
const Bytes kHello = framed("54520118", authenticated_link::kHelloDigits);
const Bytes kChallenge = framed("54520120", authenticated_link::kChallengeDigits);
const Bytes kSnapshot = framed("54520140", authenticated_link::kSnapshotDigits);

authenticated::FdLink link() {
    return {.keys = {.name = std::string(authenticated_link::kLink),
                     .secret = authenticated_link::counted_secret()},
            .sender_id = 1,
            .receiver_id = 0};
}

std::unique_ptr<NetworkDecoder> decoder_with_key() {
    auto decoder =
        std::make_unique<NetworkDecoder>(std::make_unique<authenticated::FdDecoder>(link()));
    decoder->use_seed(authenticated_link::kSeed);
    return decoder;
}
std::unique_ptr<NetworkEncoder> encoder_with_key() {
    auto encoder =
        std::make_unique<NetworkEncoder>(std::make_unique<authenticated::FdEncoder>(link()));
    encoder->use_seed(authenticated_link::seed_of(authenticated_link::kSession));
    return encoder;
}
std::unique_ptr<NetworkDecoder> plain_decoder() {
    return std::make_unique<NetworkDecoder>(
        std::make_unique<CanChannelsDecoder>(CanChannelsFormat{.fd = true}));
}
std::unique_ptr<NetworkEncoder> plain_encoder() {
    return std::make_unique<NetworkEncoder>(
        std::make_unique<CanChannelsEncoder>(CanChannelsFormat{.fd = true}));
}

/// The frame that a datagram completes.
std::optional<DecodedFrame> received(NetworkDecoder& decoder, const Bytes& datagram, Instant now) {
    DecodedFrame frame;
    std::optional<DecodedFrame> latest;
    for (std::span<const std::uint8_t> rest(datagram); decoder.next(rest, now, frame);) {
        latest.emplace(frame);
    }
    if (decoder.silence(frame)) {
        latest.emplace(frame);
    }
    return latest;
}
Bytes answer(NetworkDecoder& decoder, Instant now) {
    const auto bytes = decoder.answer(now);
    return {bytes.begin(), bytes.end()};
}
std::uint64_t refused(const NetworkDecoder& decoder, std::string_view name) {
    const auto counts = decoder.rejected();
    const auto found = std::ranges::find(counts, name, &NamedCount::name);
    return found == counts.end() ? 0 : found->count;
}

TEST(Network, SaysHelloThenSendsSnapshotsWithTheseBytes) {
    const auto encoder = encoder_with_key();
    EXPECT_TRUE(encoder->may_withhold());
    EXPECT_EQ(encoded(*encoder, sticks(at(0ms)), at(0ms)), kHello);
    EXPECT_EQ(encoder->withheld(), Withheld::no_receiver);
    EXPECT_EQ(encoded(*encoder, sticks(at(20ms)), at(20ms)), Bytes{}) << "no hello is due";
    encoder->hear(kChallenge, at(30ms));
    EXPECT_EQ(encoded(*encoder, sticks(at(32ms) - 1500us), at(32ms)), kSnapshot);
    EXPECT_EQ(encoder->withheld(), Withheld::nothing);
}

TEST(Network, AnswersAHelloOnceAndTellsTheAgeOfASnapshot) {
    const auto decoder = decoder_with_key();
    EXPECT_FALSE(received(*decoder, kHello, at(0ms)));
    EXPECT_EQ(answer(*decoder, at(0ms)), kChallenge);
    EXPECT_EQ(answer(*decoder, at(5ms)), Bytes{});
    const auto frame = received(*decoder, kSnapshot, at(12ms));
    ASSERT_TRUE(frame);
    EXPECT_TRUE(frame->channels.same_content(sticks(at(0ms))));
    EXPECT_GE(decoder->age(), 11500us) << "10 ms on the way, after 1.5 ms at the sender";
    EXPECT_LE(decoder->age(), 11550us);
}

/// A hello beside the snapshot, in one datagram.
TEST(Network, ReadsTwoMessagesOfOneDatagram) {
    const auto decoder = decoder_with_key();
    ASSERT_FALSE(received(*decoder, kHello, at(0ms)));
    answer(*decoder, at(0ms));
    Bytes both = kHello;
    append(both, kSnapshot);
    EXPECT_LE(both.size(), kLongestSerialFrame);
    EXPECT_TRUE(received(*decoder, both, at(60ms)));
    EXPECT_FALSE(answer(*decoder, at(60ms)).empty());
}

TEST(Network, WithoutAKeyTranslatesEveryChannelAndMarkBackAfterItsProof) {
    const auto encoder = plain_encoder();
    const auto decoder = plain_decoder();
    EXPECT_FALSE(encoder->may_withhold());
    std::optional<DecodedFrame> frame;
    for (Duration now = 0ms; now < 100ms; now += 20ms) {
        frame = received(*decoder, encoded(*encoder, sticks(at(now) - 3ms), at(now)), at(now));
    }
    ASSERT_TRUE(frame);
    EXPECT_TRUE(frame->channels.same_content(sticks(at(0ms))));
    EXPECT_EQ(decoder->age(), 3ms);
}

TEST(Network, RefusesAMessageOfTheOtherKindOfLink) {
    const auto plain = plain_decoder();
    EXPECT_FALSE(received(*plain, kSnapshot, at(0ms)));
    EXPECT_EQ(refused(*plain, "length"), 1U);
    const auto with_key = decoder_with_key();
    EXPECT_FALSE(received(*with_key, encoded(*plain_encoder(), sticks(at(0ms)), at(0ms)), at(0ms)));
    EXPECT_EQ(refused(*with_key, "no_key"), 1U);
    EXPECT_EQ(with_key->why_garbled(), LinkCause::no_key);
}

TEST(Network, TellsForgedMessagesFromThoseThatAreNotNew) {
    const auto decoder = decoder_with_key();
    ASSERT_FALSE(received(*decoder, kHello, at(0ms)));
    EXPECT_EQ(decoder->why_garbled(), LinkCause::garbled) << "nothing is wrong so far";
    answer(*decoder, at(0ms));
    Bytes forged = kSnapshot;
    forged.back() ^= 1U;
    EXPECT_FALSE(received(*decoder, forged, at(10ms)));
    EXPECT_EQ(decoder->why_garbled(), LinkCause::forged);
    EXPECT_TRUE(received(*decoder, kSnapshot, at(11ms)));
    EXPECT_FALSE(received(*decoder, kSnapshot, at(12ms)));
    EXPECT_EQ(decoder->why_garbled(), LinkCause::replayed);
    EXPECT_EQ(refused(*decoder, "forged"), 1U);
    EXPECT_EQ(refused(*decoder, "replayed"), 1U);
}

/// Each bit of the head, of the message and of its proof.
TEST(Network, RefusesEveryMessageWithAChangedBit) {
    const Bytes right = kSnapshot;
    const auto decoder = decoder_with_key();
    ASSERT_FALSE(received(*decoder, kHello, at(0ms)));
    answer(*decoder, at(0ms));
    for (std::size_t bit = 0; bit < 8 * right.size(); ++bit) {
        Bytes wrong = right;
        wrong[bit / 8] = static_cast<std::uint8_t>(wrong[bit / 8] ^ 1U << bit % 8);
        EXPECT_FALSE(received(*decoder, wrong, at(10ms))) << bit;
    }
    EXPECT_TRUE(received(*decoder, right, at(10ms)));
}

TEST(Network, HearsOnlyWholeAnswers) {
    const Bytes right = kChallenge;
    const auto encoder = encoder_with_key();
    for (std::size_t length = 0; length < right.size(); ++length) {
        encoder->hear(std::span(right).first(length), at(0ms));
        encoded(*encoder, sticks(at(0ms)), at(0ms));
        EXPECT_EQ(encoder->withheld(), Withheld::no_receiver) << length;
    }
    Bytes longer = right;
    longer.resize(300);
    encoder->hear(longer, at(0ms));
    encoded(*encoder, sticks(at(0ms)), at(0ms));
    EXPECT_EQ(encoder->withheld(), Withheld::no_receiver);
    encoder->hear(right, at(0ms));
    encoded(*encoder, sticks(at(0ms)), at(0ms));
    EXPECT_EQ(encoder->withheld(), Withheld::nothing);
}

TEST(Network, GoesOnWithItsReceiverAfterAReloadUnlessTheKeyIsAnother) {
    const auto before = encoder_with_key();
    before->hear(kChallenge, at(0ms));
    const auto after = encoder_with_key();
    after->continue_from(*before);
    encoded(*after, sticks(at(1ms)), at(1ms));
    EXPECT_EQ(after->withheld(), Withheld::nothing);

    authenticated::FdLink changed = link();
    changed.keys.secret[0] ^= 1U;
    NetworkEncoder other(std::make_unique<authenticated::FdEncoder>(changed));
    other.continue_from(*before);
    encoded(other, sticks(at(1ms)), at(1ms));
    EXPECT_EQ(other.withheld(), Withheld::no_receiver) << "it would send with the key of before";
}

}  // namespace
}  // namespace tribus::test::network_test
