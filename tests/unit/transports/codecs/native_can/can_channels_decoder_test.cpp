#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "tests/support/can_snapshots.h"
#include "transports/codecs/native_can/channels.h"

namespace tribus::can_channels_decoder_test {
namespace {

using namespace can_channels;
using namespace test;

/// Writes the CRC into a frame that was changed.
void seal(CanFrame& frame, std::size_t index, const CanChannelsFormat& format = {}) {
    frame.data[0] = 0;
    write_can_channels_crc(format, index, frame.bytes());
}

TEST(CanChannelsDecoder, GivesBackTheSnapshot) {
    for (const CanChannelsFormat& format : kCanFormats) {
        CanPair pair(format);
        pair.get_started();
        const ChannelFrame sent = numbered_snapshot(7);
        const auto published = pair.receive(pair.send(sent));
        ASSERT_EQ(published.size(), 1U);
        EXPECT_TRUE(published[0].same_content(sent));
    }
}

TEST(CanChannelsDecoder, KeepsAbsentChannelsAbsent) {
    for (const CanChannelsFormat& format : {CanChannelsFormat{}, CanChannelsFormat{.fd = true}}) {
        CanPair pair(format);
        pair.get_started();
        ChannelFrame sent = numbered_snapshot(7);
        sent.remove(2);
        sent.remove(17);
        const auto published = pair.receive(pair.send(sent));
        ASSERT_EQ(published.size(), 1U);
        EXPECT_TRUE(published[0].same_content(sent));
    }
}

TEST(CanChannelsDecoder, SixteenChannelsComeWithTwoSwitches) {
    CanPair pair({.channels = 16});
    pair.get_started();
    ChannelFrame sent = numbered_snapshot(7);
    sent.set(16, Pulse::from_microseconds(1501));
    sent.remove(17);
    const auto published = pair.receive(pair.send(sent));
    ASSERT_EQ(published.size(), 1U);
    EXPECT_EQ(published[0].channel(16), kSwitchOnPulse);
    EXPECT_EQ(published[0].channel(17), kSwitchOffPulse);
}

TEST(CanChannelsDecoder, KeepsOriginAndLinkQuality) {
    CanPair pair;
    pair.get_started();
    ChannelFrame sent = numbered_snapshot(7);
    sent.origin = Origin::sbus;
    sent.link_quality = 64;
    auto published = pair.receive(pair.send(sent));
    ASSERT_EQ(published.size(), 1U);
    EXPECT_EQ(published[0].origin, Origin::sbus);
    EXPECT_EQ(published[0].link_quality, 64);
    published = pair.receive(pair.send(numbered_snapshot(8)));
    ASSERT_EQ(published.size(), 1U);
    EXPECT_EQ(published[0].origin, Origin::unknown);
    EXPECT_EQ(published[0].link_quality, kNoLinkQuality);
}

TEST(CanChannelsDecoder, ValuesWereFreshWhenTheSenderGotThem) {
    for (const CanChannelsFormat& format : {CanChannelsFormat{}, CanChannelsFormat{.fd = true}}) {
        CanPair pair(format);
        pair.get_started();
        const Instant got = pair.now + kCanPeriod - milliseconds(4);
        const auto published = pair.receive(pair.send(numbered_snapshot(7, got)));
        ASSERT_EQ(published.size(), 1U);
        EXPECT_EQ(published[0].received, got);
    }
}

TEST(CanChannelsDecoder, WithoutAnAgeValuesAreFreshOnArrivalOfTheLastFrame) {
    CanPair pair({.channels = 16});
    pair.get_started();
    CanFrames frames = pair.send(numbered_snapshot(7, pair.now));
    const CanFrame last = frames.back();
    frames.pop_back();
    feed(pair.decoder, frames, pair.now);
    const auto published = feed(pair.decoder, {last}, pair.now + milliseconds(2));
    ASSERT_EQ(published.size(), 1U);
    EXPECT_EQ(published[0].received, pair.now + milliseconds(2));
}

std::map<std::string, int> details_of(const CanChannelsDecoder& decoder) {
    std::map<std::string, int> details;
    for (const FrameDetail& detail : decoder.details()) {
        details[std::string(detail.name)] = detail.values[0];
    }
    return details;
}

TEST(CanChannelsDecoder, TellsWhatElseTheFramesSay) {
    CanPair pair;
    pair.get_started();
    ChannelFrame sent = numbered_snapshot(7, pair.now + kCanPeriod - milliseconds(4));
    sent.origin = Origin::sbus;
    sent.link_quality = 64;
    pair.receive(pair.send(sent));
    EXPECT_EQ(details_of(pair.decoder),
              (std::map<std::string, int>{
                  {"counter", 3}, {"source", 2}, {"link_quality", 64}, {"age_10us", 400}}));
    sent.link_quality = kNoLinkQuality;
    sent.received = Instant{};
    pair.receive(pair.send(sent));
    EXPECT_EQ(details_of(pair.decoder),
              (std::map<std::string, int>{{"counter", 4}, {"source", 2}}));
}

TEST(CanChannelsDecoder, AnyFrameThatSaysFailsafeMakesItFailsafe) {
    for (std::size_t index = 0; index < 5; ++index) {
        CanPair pair;
        pair.get_started();
        CanFrames frames = pair.send(numbered_snapshot(7));
        frames[index].data[1] |= 0x10;
        seal(frames[index], index);
        auto published = pair.receive(frames);
        ASSERT_EQ(published.size(), 1U);
        EXPECT_TRUE(published[0].failsafe);
        EXPECT_FALSE(published[0].frame_lost);

        frames = pair.send(numbered_snapshot(8));
        frames[index].data[1] |= 0x20;
        seal(frames[index], index);
        published = pair.receive(frames);
        ASSERT_EQ(published.size(), 1U);
        EXPECT_TRUE(published[0].frame_lost);
        EXPECT_FALSE(published[0].failsafe);
    }
}

TEST(CanChannelsDecoder, PublishesFromTheThirdSnapshotOn) {
    for (const CanChannelsFormat& format : kCanFormats) {
        CanPair pair(format);
        EXPECT_TRUE(pair.receive(pair.send(numbered_snapshot(1))).empty());
        EXPECT_TRUE(pair.receive(pair.send(numbered_snapshot(2))).empty());
        EXPECT_EQ(pair.receive(pair.send(numbered_snapshot(3))).size(), 1U);
        EXPECT_EQ(pair.receive(pair.send(numbered_snapshot(4))).size(), 1U);
        EXPECT_EQ(rejected(pair.decoder, "unconfirmed"), 2U);
    }
}

TEST(CanChannelsDecoder, PublishesOnwardsOverTheEndOfTheCounter) {
    for (const CanChannelsFormat& format : kCanFormats) {
        CanPair pair(format);
        pair.get_started();
        for (int count = 0; count < 600; ++count) {
            ASSERT_EQ(pair.receive(pair.send(numbered_snapshot(count))).size(), 1U) << count;
        }
    }
}

TEST(CanChannelsDecoder, ASnapshotThatLacksAFrameIsNotPublished) {
    for (std::size_t lost = 0; lost < 5; ++lost) {
        CanPair pair;
        pair.get_started();
        CanFrames frames = pair.send(numbered_snapshot(7));
        frames.erase(frames.begin() + static_cast<std::ptrdiff_t>(lost));
        EXPECT_TRUE(pair.receive(frames).empty());
        const ChannelFrame next = numbered_snapshot(8);
        const auto published = pair.receive(pair.send(next));
        ASSERT_EQ(published.size(), 1U) << "the next one counts again";
        EXPECT_TRUE(published[0].same_content(next));
        EXPECT_EQ(rejected(pair.decoder, "incomplete"), lost == 0 ? 0U : 1U);
        EXPECT_GE(rejected(pair.decoder, "incomplete") + rejected(pair.decoder, "stray"), 1U);
    }
}

TEST(CanChannelsDecoder, AWrongChecksumIsCountedAndDropsTheFrame) {
    for (const CanChannelsFormat& format : kCanFormats) {
        CanPair pair(format);
        pair.get_started();
        CanFrames frames = pair.send(numbered_snapshot(7));
        frames.back().data[2] ^= 0x40;
        EXPECT_TRUE(pair.receive(frames).empty());
        EXPECT_EQ(rejected(pair.decoder, "checksum"), 1U);
    }
}

TEST(CanChannelsDecoder, OnlyTheProfileThatIsSetPasses) {
    CanChannelsEncoder p01({.crc = CanChannelsCrc::p01});
    CanChannelsDecoder p22;
    for (int count = 0; count < 10; ++count) {
        EXPECT_TRUE(
            feed(p22, can_frames(p01, numbered_snapshot(count)), can_time(count * kCanPeriod))
                .empty());
    }
    EXPECT_GE(rejected(p22, "checksum"), 45U);
}

TEST(CanChannelsDecoder, Profile1HasNoCounter15) {
    const CanChannelsFormat format{.crc = CanChannelsCrc::p01};
    CanChannelsEncoder encoder(format);
    CanChannelsDecoder decoder(format);
    CanFrame frame = can_frames(encoder, numbered_snapshot(1))[0];
    frame.data[1] |= 0x0F;
    seal(frame, 0, format);
    decoder.next(frame, can_time({}));
    EXPECT_EQ(rejected(decoder, "checksum"), 1U);
}

TEST(CanChannelsDecoder, OtherKindsOfFrameOnItsIdsAreCountedAndDropped) {
    CanChannelsEncoder encoder;
    const CanFrame good = can_frames(encoder, numbered_snapshot(1))[0];
    CanFrame remote = good;
    remote.remote = true;
    CanFrame fd = good;
    fd.fd = true;
    CanFrame brief = good;
    brief.length = 7;
    CanChannelsDecoder decoder;
    std::uint64_t count = 0;
    for (const CanFrame& frame : {remote, fd, brief}) {
        EXPECT_FALSE(decoder.next(frame, can_time({})));
        EXPECT_EQ(rejected(decoder, "length"), ++count);
    }
    CanFrame classic = good;
    classic.id = 0x305;
    CanChannelsDecoder of_fd({.fd = true});
    EXPECT_FALSE(of_fd.next(classic, can_time({})));
    EXPECT_EQ(rejected(of_fd, "length"), 1U);
}

TEST(CanChannelsDecoder, PassesOverOtherIds) {
    CanPair pair;
    pair.get_started();
    CanFrames frames = pair.send(numbered_snapshot(7));
    CanFrame other = frames[0];
    other.id = 0x2FF;
    CanFrame above = frames[0];
    above.id = 0x305;
    CanFrame extended = frames[0];
    extended.extended = true;
    frames.insert(frames.begin() + 2, {other, above, extended});
    EXPECT_EQ(pair.receive(frames).size(), 1U);
}

TEST(CanChannelsDecoder, AFrozenSenderIsNotPublishedAgain) {
    for (const CanChannelsFormat& format : kCanFormats) {
        CanPair pair(format);
        pair.get_started();
        const CanFrames frozen = pair.send(numbered_snapshot(7));
        EXPECT_EQ(pair.receive(frozen).size(), 1U);
        for (int count = 1; count <= 1000; ++count) {
            pair.now += kCanPeriod;
            EXPECT_TRUE(pair.receive(frozen).empty());
        }
        EXPECT_EQ(rejected(pair.decoder, "repeated"), 1000U);
    }
}

TEST(CanChannelsDecoder, AFrozenSenderIsNeverPublishedHoweverSlowItIs) {
    CanPair pair;
    const CanFrames frozen = pair.send(numbered_snapshot(7));
    for (int count = 0; count < 20; ++count) {
        pair.now += milliseconds(300);
        EXPECT_TRUE(pair.receive(frozen).empty());
    }
}

TEST(CanChannelsDecoder, TwoLostSnapshotsAreNoReasonToStop) {
    CanPair pair;
    pair.get_started();
    pair.send(numbered_snapshot(4));
    pair.send(numbered_snapshot(5));
    EXPECT_EQ(pair.receive(pair.send(numbered_snapshot(6))).size(), 1U);
}

TEST(CanChannelsDecoder, ALargerStepOfTheCounterNeedsProofAgain) {
    for (const CanChannelsFormat& format : kCanFormats) {
        CanPair pair(format);
        pair.get_started();
        for (int count = 0; count < 3; ++count) {
            pair.send(numbered_snapshot(4));
        }
        EXPECT_TRUE(pair.receive(pair.send(numbered_snapshot(7))).empty());
        EXPECT_EQ(rejected(pair.decoder, "counter_jump"), 1U);
        EXPECT_TRUE(pair.receive(pair.send(numbered_snapshot(8))).empty());
        EXPECT_EQ(pair.receive(pair.send(numbered_snapshot(9))).size(), 1U);
    }
}

TEST(CanChannelsDecoder, ASilenceNeedsProofAgain) {
    CanPair pair;
    pair.get_started();
    pair.now += CanChannelsDecoder::kSilence;
    EXPECT_TRUE(pair.receive(pair.send(numbered_snapshot(7))).empty());
    EXPECT_TRUE(pair.receive(pair.send(numbered_snapshot(8))).empty());
    EXPECT_EQ(pair.receive(pair.send(numbered_snapshot(9))).size(), 1U);
}

TEST(CanChannelsDecoder, APauseShorterThanTheSilenceDoesNot) {
    CanPair pair;
    pair.get_started();
    pair.now += CanChannelsDecoder::kSilence - kCanPeriod;
    EXPECT_EQ(pair.receive(pair.send(numbered_snapshot(7))).size(), 1U);
}

// The default transmit queue of a CAN device is 10 frames (docs/protocols/can.md, "SocketCAN:
// transmit queue").
TEST(CanChannelsDecoder, AQueueThatEmptiesAfterAnOutageIsNotPublished) {
    CanPair pair;
    pair.get_started();
    CanFrames queue = pair.send(numbered_snapshot(7));
    for (const CanFrame& frame : pair.send(numbered_snapshot(8))) {
        queue.push_back(frame);
    }
    pair.now += std::chrono::seconds(5);
    EXPECT_TRUE(pair.receive(queue).empty());
}

TEST(CanChannelsDecoder, PartsMustArriveWithinTheWindow) {
    for (const bool late : {false, true}) {
        CanPair pair;
        pair.get_started();
        CanFrames frames = pair.send(numbered_snapshot(7));
        const CanFrame last = frames.back();
        frames.pop_back();
        feed(pair.decoder, frames, pair.now);
        const Instant arrival = pair.now + CanChannelsDecoder::kWindow + microseconds(late ? 1 : 0);
        EXPECT_EQ(feed(pair.decoder, {last}, arrival).size(), late ? 0U : 1U);
        EXPECT_EQ(rejected(pair.decoder, "incomplete"), late ? 1U : 0U);
    }
}

// Rear frames left in a controller, and the front of the next snapshot with the same counter.
TEST(CanChannelsDecoder, LeftOversAreNeverCompletedByALaterFront) {
    CanPair pair;
    pair.get_started();
    CanFrames stuck = pair.send(numbered_snapshot(7));
    stuck.erase(stuck.begin());
    for (int count = 0; count < 15; ++count) {
        pair.send(numbered_snapshot(8));
    }
    const CanFrames next = pair.send(numbered_snapshot(9));
    ASSERT_EQ(stuck[0].data[1] & 0x0F, next[0].data[1] & 0x0F);
    EXPECT_TRUE(pair.receive(stuck).empty());
    EXPECT_TRUE(pair.receive({next[0]}).empty());
}

TEST(CanChannelsDecoder, AFrameThatTheBusRepeatsIsTakenOnce) {
    for (std::size_t twice = 0; twice < 5; ++twice) {
        CanPair pair;
        pair.get_started();
        const ChannelFrame sent = numbered_snapshot(7);
        CanFrames frames = pair.send(sent);
        frames.insert(frames.begin() + static_cast<std::ptrdiff_t>(twice), frames[twice]);
        const auto published = pair.receive(frames);
        ASSERT_EQ(published.size(), 1U) << twice;
        EXPECT_TRUE(published[0].same_content(sent));
        EXPECT_EQ(pair.receive(pair.send(numbered_snapshot(8))).size(), 1U) << twice;
    }
}

TEST(CanChannelsDecoder, TwoContentsUnderOneCounterSpoilTheSnapshotAndNeedProofAgain) {
    CanPair pair;
    CanChannelsEncoder second;
    CanChannelsEncoder first;
    for (int count = 0; count < 3; ++count) {
        pair.receive(can_frames(first, numbered_snapshot(count)));
        can_frames(second, numbered_snapshot(count));
    }
    const CanFrames ours = can_frames(first, numbered_snapshot(7));
    const CanFrames theirs = can_frames(second, numbered_snapshot(500));
    EXPECT_TRUE(pair.receive({ours[0], ours[1], theirs[1], ours[2], ours[3], ours[4]}).empty());
    EXPECT_EQ(rejected(pair.decoder, "conflict"), 1U);
    EXPECT_TRUE(pair.receive(can_frames(first, numbered_snapshot(8))).empty());
}

// A repeated first frame must not start a snapshot that frames of another sender would complete.
TEST(CanChannelsDecoder, ASpoiltSnapshotIsNotBegunAgain) {
    CanChannelsEncoder first;
    CanChannelsEncoder second;
    CanChannelsDecoder decoder;
    const CanFrames ours = can_frames(first, numbered_snapshot(7));
    const CanFrames theirs = can_frames(second, numbered_snapshot(500));
    feed(decoder, {ours[0], theirs[0], theirs[0], ours[1], ours[2], ours[3], ours[4]},
         can_time({}));
    EXPECT_EQ(rejected(decoder, "conflict"), 1U);
    EXPECT_EQ(rejected(decoder, "unconfirmed"), 0U) << "no snapshot became whole";
}

}  // namespace
}  // namespace tribus::can_channels_decoder_test
