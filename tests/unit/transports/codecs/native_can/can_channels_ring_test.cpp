#include <gtest/gtest.h>

#include <chrono>
#include <cstddef>
#include <deque>
#include <string>

#include "tests/support/can_snapshots.h"
#include "transports/codecs/native_can/channels.h"

/// Old snapshots that are repeated in a ring, and a second sender of the same ids.
namespace tribus::can_channels_ring_test {
namespace {

using namespace test;

constexpr Duration kSlowPeriod = milliseconds(20);

/// A live sender at 50 Hz until `now`, and its latest snapshots.
class LiveSender {
  public:
    explicit LiveSender(const CanChannelsFormat& format) : format_(format), decoder(format) {
        for (int number = 0; number < 603; ++number) {
            send(number);
        }
    }
    std::size_t send(int number) {
        now += kSlowPeriod;
        sent_.push_back(can_frames(encoder_, numbered_snapshot(number, now), now));
        return feed(decoder, sent_.back(), now).size();
    }
    /// Repeats the latest `length` snapshots for ten seconds. Returns how many are published.
    std::size_t repeat_latest(std::size_t length) {
        std::size_t published = 0;
        for (std::size_t turn = 0; turn < 500; ++turn) {
            now += kSlowPeriod;
            const CanFrames& old = sent_[sent_.size() - length + turn % length];
            published += feed(decoder, old, now).size();
        }
        return published;
    }
    /// Time from the first snapshot of a sender that restarts until one is published.
    Duration restart(Duration pause) {
        encoder_.continue_from(CanChannelsEncoder(format_));
        now += pause;
        const Instant begin = now + kSlowPeriod;
        while (send(7) == 0 && now - begin < std::chrono::seconds(60)) {
        }
        return now - begin;
    }

    CanChannelsFormat format_;
    CanChannelsDecoder decoder;
    Instant now = can_time({});

  private:
    CanChannelsEncoder encoder_{format_};
    std::deque<CanFrames> sent_;
};

class CanChannelsRing : public testing::TestWithParam<CanChannelsFormat> {};

TEST_P(CanChannelsRing, WithOldSnapshotsIsNeverPublishedUnlessItHasAllCounts) {
    for (std::size_t length = 2; length < GetParam().counter_values(); ++length) {
        LiveSender sender(GetParam());
        ASSERT_EQ(sender.send(1), 1U);
        EXPECT_EQ(sender.repeat_latest(length), 0U) << length;
    }
}

TEST_P(CanChannelsRing, AfterARingALiveSenderIsBelievedAgain) {
    LiveSender sender(GetParam());
    sender.repeat_latest(3);
    const Duration took = sender.restart(Duration::zero());
    EXPECT_LE(took, kSlowPeriod * static_cast<int>(GetParam().counter_values() + 1));
}

// A process that is restarted at once, and one that takes some time.
TEST_P(CanChannelsRing, ARestartIsBelievedAfterAllCountsOrAfterThreeSnapshots) {
    const auto in_milliseconds = [](Duration time) {
        return static_cast<int>(std::chrono::duration_cast<milliseconds>(time).count());
    };
    LiveSender at_once(GetParam());
    const Duration quick = at_once.restart(Duration::zero());
    LiveSender later(GetParam());
    const Duration slow = later.restart(CanChannelsDecoder::kSilence);
    RecordProperty("at_once_ms", in_milliseconds(quick));
    RecordProperty("after_a_pause_ms", in_milliseconds(slow));
    EXPECT_EQ(quick, kSlowPeriod * static_cast<int>(GetParam().counter_values()));
    EXPECT_EQ(slow, 2 * kSlowPeriod);
}

TEST_P(CanChannelsRing, ASecondSenderFiveTimesAsRareIsPublishedOnceAtMost) {
    for (int offset = 2; offset < 20; ++offset) {
        CanChannelsEncoder first(GetParam());
        CanChannelsEncoder second(GetParam());
        CanChannelsDecoder decoder(GetParam());
        std::size_t of_the_second = 0;
        for (int turn = 0; turn < 900; ++turn) {
            const Instant now = can_time(kSlowPeriod * turn);
            feed(decoder, can_frames(first, numbered_snapshot(turn % 300, now), now), now);
            if (turn >= 100 && turn % 5 == 0) {
                const Instant then = now + milliseconds(offset);
                of_the_second +=
                    feed(decoder, can_frames(second, numbered_snapshot(500, then), then), then)
                        .size();
            }
        }
        EXPECT_LE(of_the_second, 1U) << offset;
    }
}

INSTANTIATE_TEST_SUITE_P(Formats, CanChannelsRing, testing::ValuesIn(kCanFormats),
                         [](const testing::TestParamInfo<CanChannelsFormat>& format) {
                             return std::string(format.param.fd         ? "Fd"
                                                : format.param.extended ? "Extended16"
                                                : format.param.crc == CanChannelsCrc::p01 ? "P01"
                                                                                          : "P22");
                         });

}  // namespace
}  // namespace tribus::can_channels_ring_test
