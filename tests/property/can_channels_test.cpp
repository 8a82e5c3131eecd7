#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "tests/support/can_snapshots.h"
#include "tests/support/streams.h"
#include "transports/codecs/native_can/channels.h"
#include "transports/codecs/sbus/sbus.h"

namespace tribus::can_channels_test {
namespace {

using namespace can_channels;
using namespace test;

constexpr std::array<std::string_view, 5> kScales{"betaflight", "ardupilot", "px4", "frsky",
                                                  "futaba"};

TEST(CanChannelsProperty, AllSbusValuesOfEveryScaleComeBack) {
    for (const PulseScale& wire : {kClassicPulse, kFdPulse}) {
        for (const std::string_view name : kScales) {
            const SbusScale scale = *SbusScale::named(name);
            for (std::uint16_t raw = 0; raw <= kSbusRawMost; ++raw) {
                const auto back = from_wire(wire, to_wire(wire, scale.decode(raw)));
                ASSERT_TRUE(back);
                ASSERT_EQ(scale.encode(*back), raw) << name;
            }
        }
    }
}

TEST(CanChannelsProperty, AllIbusMicrosecondsOfTheRangeComeBack) {
    for (int microseconds = 476; microseconds <= 2523; ++microseconds) {
        const Pulse pulse = Pulse::from_microseconds(microseconds);
        ASSERT_EQ(from_wire(kClassicPulse, to_wire(kClassicPulse, pulse)), pulse);
        ASSERT_EQ(from_wire(kFdPulse, to_wire(kFdPulse, pulse)), pulse);
    }
}

/// Encoding a decoded wire value gives the same wire value.
TEST(CanChannelsProperty, AllWireValuesComeBack) {
    for (std::uint16_t raw = 0; raw <= 4095; ++raw) {
        ASSERT_EQ(to_wire(kClassicPulse, from_wire(kClassicPulse, raw)), raw);
    }
    for (std::uint16_t raw = 0; raw <= 32767; ++raw) {
        ASSERT_EQ(to_wire(kFdPulse, from_wire(kFdPulse, raw)), raw);
    }
}

/// Returns an SBUS frame after two gateways with CAN between them.
SbusFrame over_can(const SbusFrame& frame, CanPair& pair, const SbusScale& scale) {
    ChannelFrame snapshot;
    for (std::size_t channel = 0; channel < kSbusChannels; ++channel) {
        snapshot.set(channel, scale.decode(frame.raw[channel]));
    }
    snapshot.set(16, frame.channel_17 ? kSwitchOnPulse : kSwitchOffPulse);
    snapshot.set(17, frame.channel_18 ? kSwitchOnPulse : kSwitchOffPulse);
    snapshot.frame_lost = frame.frame_lost;
    snapshot.failsafe = frame.failsafe;
    const auto published = pair.receive(pair.send(snapshot));
    std::array<std::uint8_t, kLongestSerialFrame> wire{};
    if (!published.empty()) {
        SbusEncoder(scale).write(published[0], wire, Instant{});
    }
    return parse_sbus(std::span(wire).first<kSbusFrameLength>());
}

RC_GTEST_PROP(CanChannelsProperty, SbusFramesPassUnchanged, ()) {
    const auto format = *rc::gen::elementOf(kCanFormats);
    const SbusScale scale = *SbusScale::named(*rc::gen::elementOf(kScales));
    CanPair pair(format);
    pair.get_started();
    SbusFrame frame;
    for (std::uint16_t& raw : frame.raw) {
        raw = *rc::gen::inRange<std::uint16_t>(0, kSbusRawMost + 1);
    }
    frame.channel_17 = *rc::gen::arbitrary<bool>();
    frame.channel_18 = *rc::gen::arbitrary<bool>();
    frame.frame_lost = *rc::gen::arbitrary<bool>();
    frame.failsafe = *rc::gen::arbitrary<bool>();
    RC_ASSERT(over_can(frame, pair, scale) == frame);
}

ChannelFrame any_snapshot(Instant now) {
    ChannelFrame snapshot;
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        if (*rc::gen::arbitrary<bool>()) {
            snapshot.set(channel, Pulse::from_eighths(*rc::gen::inRange(-33000, 33000)));
        }
    }
    snapshot.failsafe = *rc::gen::arbitrary<bool>();
    snapshot.frame_lost = *rc::gen::arbitrary<bool>();
    snapshot.origin = *rc::gen::element(Origin::none, Origin::ibus, Origin::sbus, Origin::dronecan,
                                        Origin::can, Origin::dbc, Origin::unknown);
    snapshot.link_quality = static_cast<std::uint8_t>(
        *rc::gen::oneOf(rc::gen::inRange(0, 101), rc::gen::just(int{kNoLinkQuality})));
    snapshot.received = now - microseconds(*rc::gen::inRange(0, 63000));
    return snapshot;
}

RC_GTEST_PROP(CanChannelsProperty, EverySnapshotComesBackAtTheResolutionOfTheWire, ()) {
    const bool fd = *rc::gen::arbitrary<bool>();
    CanPair pair({.fd = fd});
    pair.get_started();
    const ChannelFrame sent = any_snapshot(pair.now + kCanPeriod);
    const auto published = pair.receive(pair.send(sent));
    RC_ASSERT(published.size() == 1);
    const int step = fd ? 1 : 4;
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        RC_ASSERT(published[0].has(channel) == sent.has(channel));
        if (sent.has(channel)) {
            const int least = fd ? 0 : 476 * 8;
            const int most = fd ? 32767 : 2523 * 8;
            const int limited = std::clamp(sent.channel(channel)->eighths(), least, most);
            RC_ASSERT(2 * std::abs(published[0].channel(channel)->eighths() - limited) <= step);
        }
    }
    RC_ASSERT(published[0].failsafe == sent.failsafe);
    RC_ASSERT(published[0].frame_lost == sent.frame_lost);
    RC_ASSERT(published[0].origin == sent.origin);
    RC_ASSERT(published[0].link_quality == sent.link_quality);
    const Duration error = published[0].received - sent.received;
    RC_ASSERT(2 * std::chrono::abs(error) <= microseconds(fd ? 10 : 250));
}

/// Returns the frame with each single bit flipped, as the kernel delivers it, with its id and
/// flags.
std::vector<CanFrame> damaged_versions(const CanFrame& frame) {
    std::vector<CanFrame> versions;
    for (std::size_t bit = 0; bit < 8U * frame.length; ++bit) {
        versions.push_back(frame);
        versions.back().data[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
    }
    for (unsigned bit = 0; bit < (frame.extended ? 29U : 11U); ++bit) {
        versions.push_back(frame);
        versions.back().id ^= 1U << bit;
    }
    for (bool CanFrame::*kind : {&CanFrame::extended, &CanFrame::remote, &CanFrame::fd}) {
        versions.push_back(frame);
        versions.back().*kind = !(versions.back().*kind);
    }
    for (std::uint8_t length = 0; length < frame.length; ++length) {
        versions.push_back(frame);
        versions.back().length = length;
    }
    return versions;
}

TEST(CanChannelsProperty, ADamagedBitNeverChangesWhatIsPublished) {
    for (const CanChannelsFormat& format : kCanFormats) {
        for (std::size_t part = 0; part < format.frame_count(); ++part) {
            CanChannelsEncoder probe(format);
            const std::size_t versions =
                damaged_versions(can_frames(probe, numbered_snapshot(7))[part]).size();
            CanPair pair(format);
            pair.get_started();
            for (std::size_t version = 0; version < versions; ++version) {
                CanFrames frames = pair.send(numbered_snapshot(7, pair.now));
                frames[part] = damaged_versions(frames[part])[version];
                ASSERT_TRUE(pair.receive(frames).empty()) << "version " << version;
                const ChannelFrame next = numbered_snapshot(8, pair.now);
                const auto published = pair.receive(pair.send(next));
                ASSERT_EQ(published.size(), 1U) << "version " << version;
                ASSERT_TRUE(published[0].same_content(next));
            }
        }
    }
}

/// A frame on the bus and its time of arrival.
struct Arrival {
    Instant at{};
    CanFrame frame;
};

/// Sends `count` snapshots. Each frame may be lost, doubled, or late by up to `most_delay`.
std::vector<Arrival> over_a_bad_bus(CanChannelsEncoder& encoder, Random& random, int count,
                                    Duration period, Duration most_delay) {
    std::vector<Arrival> arrivals;
    for (int number = 0; number < count; ++number) {
        const Instant sent = can_time(number * period);
        Instant free = sent;
        for (const CanFrame& frame : can_frames(encoder, numbered_snapshot(number, sent), sent)) {
            free += microseconds(135);
            const std::uint32_t fate = random.below(40);
            const Duration delay = microseconds(
                random.below(static_cast<std::uint32_t>(most_delay / microseconds(1)) + 1));
            if (fate == 0) {
                continue;
            }
            arrivals.push_back({fate == 1 ? free + delay : free, frame});
            if (fate == 2) {
                arrivals.push_back({free + delay, frame});
            }
        }
    }
    std::ranges::stable_sort(arrivals, {}, &Arrival::at);
    return arrivals;
}

int number_of(const ChannelFrame& snapshot) {
    return snapshot.channel(0)->whole_microseconds() - 1000;
}

/// Delays are shorter than one round of the counter, because a later frame looks like one of
/// another sender. A late frame is an old one, so some of these senders publish little.
TEST(CanChannelsProperty, OnABadBusOnlySnapshotsThatWereSentComeOut) {
    int all_published = 0;
    for (std::uint32_t seed = 1; seed <= 400; ++seed) {
        const CanChannelsFormat& format = kCanFormats[seed % kCanFormats.size()];
        CanChannelsEncoder encoder(format);
        CanChannelsDecoder decoder(format);
        Random random(seed);
        const auto arrivals =
            over_a_bad_bus(encoder, random, 200, milliseconds(2), milliseconds(12));
        int published = 0;
        int latest = -1;
        for (const Arrival& arrival : arrivals) {
            const auto snapshot = decoder.next(arrival.frame, arrival.at);
            if (!snapshot) {
                continue;
            }
            ++published;
            const int number = number_of(*snapshot);
            ASSERT_TRUE(snapshot->same_content(numbered_snapshot(number))) << "seed " << seed;
            ASSERT_GT(number, latest) << "seed " << seed;
            ASSERT_LE(arrival.at - can_time(number * milliseconds(2)),
                      CanChannelsDecoder::kWindow + milliseconds(12))
                << "seed " << seed;
            latest = number;
        }
        all_published += published;
    }
    EXPECT_GT(all_published, 400 * 100);
}

/// Merges the frames of two snapshots. Each bit of `order`, lowest first, tells which one is next.
CanFrames merged(const CanFrames& first, const CanFrames& second, unsigned order) {
    CanFrames frames;
    std::size_t of_first = 0;
    std::size_t of_second = 0;
    for (; of_first < first.size() || of_second < second.size(); order >>= 1U) {
        const bool take_second =
            of_first == first.size() || ((order & 1U) != 0 && of_second < second.size());
        frames.push_back(take_second ? second[of_second++] : first[of_first++]);
    }
    return frames;
}

/// Number of values of `order`, so that all ways to merge two snapshots are tried.
unsigned orders(const CanChannelsFormat& format) {
    return 1U << (2 * format.frame_count() - 1);
}

class TwoSenders : public testing::TestWithParam<std::size_t> {
  protected:
    CanChannelsFormat format_ = kCanFormats[GetParam()];
};

TEST_P(TwoSenders, WithOnePeriodAndPhaseAreNeverPublished) {
    for (unsigned ahead = 0; ahead < format_.counter_values(); ++ahead) {
        for (unsigned order = 0; order < orders(format_); ++order) {
            CanPair pair(format_);
            CanChannelsEncoder second(format_);
            for (unsigned count = 0; count < ahead; ++count) {
                can_frames(second, numbered_snapshot(0));
            }
            for (int count = 0; count < 6; ++count) {
                const CanFrames ours = pair.send(numbered_snapshot(count));
                const CanFrames theirs = can_frames(second, numbered_snapshot(500 + count));
                ASSERT_TRUE(pair.receive(merged(ours, theirs, order)).empty())
                    << ahead << " ahead, order " << order;
            }
        }
    }
}

TEST_P(TwoSenders, ThatMingleInAnyWayAreNeverMixed) {
    for (std::uint32_t seed = 1; seed <= 2000; ++seed) {
        Random random(seed);
        CanPair pair(format_);
        CanChannelsEncoder second(format_);
        for (unsigned count = random.below(format_.counter_values()); count > 0; --count) {
            can_frames(second, numbered_snapshot(0));
        }
        for (int count = 0; count < 40; ++count) {
            // One of the two senders may be alone for a while.
            const bool alone = random.below(4) == 0;
            const CanFrames ours = pair.send(numbered_snapshot(count));
            const CanFrames theirs =
                alone ? CanFrames{} : can_frames(second, numbered_snapshot(500 + count));
            for (const ChannelFrame& snapshot :
                 pair.receive(merged(ours, theirs, random.below(orders(format_))))) {
                const int number = number_of(snapshot);
                ASSERT_TRUE(number == count || number == 500 + count) << "seed " << seed;
                ASSERT_TRUE(snapshot.same_content(numbered_snapshot(number))) << "seed " << seed;
            }
        }
    }
}

TEST_P(TwoSenders, NeedOnlyOneToStopForTheOtherToBeHeard) {
    CanPair pair(format_);
    CanChannelsEncoder second(format_);
    can_frames(second, numbered_snapshot(0));
    for (int count = 0; count < 20; ++count) {
        const CanFrames ours = pair.send(numbered_snapshot(count));
        pair.receive(merged(ours, can_frames(second, numbered_snapshot(500 + count)), 0));
    }
    std::size_t published = 0;
    for (int count = 20; count < 25; ++count) {
        published += pair.receive(pair.send(numbered_snapshot(count))).size();
    }
    EXPECT_GE(published, 2U);
}

INSTANTIATE_TEST_SUITE_P(Formats, TwoSenders, testing::Range(std::size_t{0}, kCanFormats.size()));

}  // namespace
}  // namespace tribus::can_channels_test
