#include <gtest/gtest.h>

#include "tests/support/can_snapshots.h"
#include "transports/codecs/native_can/channels.h"

/// Two senders with the same ids, and a sender that continues for another.
namespace tribus::can_channels_senders_test {
namespace {

using namespace test;

TEST(CanChannelsSenders, ThatCutInOnEachOtherNeedProofAgain) {
    CanPair ours;
    ours.get_started();
    CanChannelsEncoder second;
    for (unsigned count = 0; count <= CanChannelsDecoder::kProof + 1; ++count) {
        can_frames(second, numbered_snapshot(500));
    }
    const CanFrames cut = ours.send(numbered_snapshot(7));
    ours.now += kCanPeriod / 2;  // late enough for a lost snapshot
    CanFrames theirs = can_frames(second, numbered_snapshot(501));
    theirs.insert(theirs.begin(), {cut[0], cut[1]});
    theirs.push_back(cut[2]);  // a single sender would have finished that snapshot
    EXPECT_EQ(ours.receive(theirs).size(), 1U);
    EXPECT_TRUE(ours.receive(can_frames(second, numbered_snapshot(502))).empty());
}

TEST(CanChannelsSenders, GoOnCountingWhereAnotherConfigurationTakesOver) {
    CanPair pair;
    pair.get_started();
    CanChannelsEncoder next;
    next.continue_from(pair.encoder);
    pair.now += kCanPeriod;
    const CanFrames frames = can_frames(next, numbered_snapshot(7), pair.now);
    EXPECT_EQ(pair.receive(frames).size(), 1U);
}

}  // namespace
}  // namespace tribus::can_channels_senders_test
