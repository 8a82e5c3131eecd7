#include "app/wire/dronecan/dronecan_explainer.h"

#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/streams.h"
#include "transports/recordings/recording.h"

namespace tribus::dronecan_explainer_test {
namespace {

using std::chrono::microseconds;
using test::Bytes;
using test::from_hex;

/// RCInput of node 42 with transfer id 5, the first worked example (docs/protocols/can.md,
/// "DroneCAN: worked examples").
const std::vector<std::string> kRcInput{"0804742A#13C30100C80E8385", "0804742A#4C4B04145785DC25",
                                        "0804742A#5406A460876C7D05", "0804742A#07DC3DC7DB5DD525",
                                        "0804742A#DE5045"};
/// The same node with transfer id 31 and failsafe, the second worked example.
const std::vector<std::string> kFailsafe{"0804742A#1F670200000DC59F", "0804742A#DC5843DC5DC5DC3F",
                                         "0804742A#5DC5DC5DC5DC5D1F", "0804742A#C5DC5DC5DC5DC53F",
                                         "0804742A#DC505F"};

/// Returns the explained transfers of frames that come every millisecond from 1 s on.
std::vector<ExplainedTransfer> explained(const std::vector<std::string>& frames,
                                         TransferTally* tally = nullptr,
                                         Duration between = std::chrono::milliseconds(1)) {
    std::string log;
    Duration at = std::chrono::seconds(1);
    for (const std::string& frame : frames) {
        const auto us = std::chrono::duration_cast<microseconds>(at).count();
        std::string fraction = std::to_string(us % 1'000'000);
        fraction.insert(0, 6 - fraction.size(), '0');
        log += "(" + std::to_string(us / 1'000'000) + "." + fraction + ") can0 " + frame + "\n";
        at += between;
    }
    const auto recording = parse_recording(log, "can.log", RecordingKind::candump);
    EXPECT_TRUE(recording) << recording.error();
    std::vector<ExplainedTransfer> found;
    DroneCanExplainer explainer(
        [&found](const ExplainedTransfer& transfer) { found.push_back(transfer); });
    if (recording) {
        for (const RecordedCanFrame& frame : recording->can_frames) {
            explainer.feed(frame);
        }
    }
    explainer.finish();
    if (tally != nullptr) {
        *tally = explainer.tally();
    }
    return found;
}

using Faults = std::vector<TransferFault>;

Faults faults(const std::vector<ExplainedTransfer>& transfers) {
    Faults found;
    for (const ExplainedTransfer& transfer : transfers) {
        found.push_back(transfer.fault);
    }
    return found;
}

std::vector<std::string> joined(std::vector<std::string> frames,
                                const std::vector<std::string>& more) {
    frames.insert(frames.end(), more.begin(), more.end());
    return frames;
}
std::vector<std::string> without(std::vector<std::string> frames, std::ptrdiff_t at) {
    frames.erase(frames.begin() + at);
    return frames;
}

TEST(DroneCanExplainer, AWholeTransferHasItsHeadItsFramesAndItsPayloadWithoutTheCrc) {
    const auto found = explained(kRcInput);
    ASSERT_EQ(found.size(), 1U);
    const ExplainedTransfer& transfer = found.front();
    EXPECT_EQ(transfer.fault, TransferFault::none);
    EXPECT_EQ(transfer.head.source, 42);
    EXPECT_EQ(transfer.head.priority, 8);
    EXPECT_EQ(transfer.head.transfer_id, 5);
    ASSERT_NE(transfer.type, nullptr);
    EXPECT_EQ(transfer.type->type.name, "dronecan.sensors.rc.RCInput");
    EXPECT_EQ(transfer.frames, 5U);
    EXPECT_EQ(transfer.payload,
              from_hex("0100C80E834C4B04145785DC5406A460876C7D07DC3DC7DB5DD5DE50"));
    EXPECT_EQ(transfer.first_at, Duration::zero());
    EXPECT_EQ(transfer.last_at, std::chrono::milliseconds(4));
}

TEST(DroneCanExplainer, ADamagedByteIsABadCrc) {
    auto damaged = kRcInput;
    damaged[2] = "0804742A#5406A460876C7C05";
    const auto found = explained(damaged);
    ASSERT_EQ(faults(found), Faults{TransferFault::bad_crc});
    EXPECT_EQ(found.front().payload,
              from_hex("0100C80E834C4B04145785DC5406A460876C7C07DC3DC7DB5DD5DE50"));
}

TEST(DroneCanExplainer, AFrameLostWithinATransferIsSeenByTheToggleWhereverItWas) {
    for (const std::ptrdiff_t lost : {1, 2, 3}) {
        const auto found = explained(joined(without(kRcInput, lost), kFailsafe));
        EXPECT_EQ(faults(found), (Faults{TransferFault::frames_missing, TransferFault::none}))
            << "frame " << lost;
    }
}

TEST(DroneCanExplainer, AnEndThatCannotFollowShowsThatAFrameIsMissing) {
    // The third worked example without its middle frame.
    const std::vector<std::string> command{"0803F20A#61B7010000000282", "0803F20A#0400003842"};
    const auto found = explained(command);
    ASSERT_EQ(faults(found), Faults{TransferFault::frames_missing});
    EXPECT_EQ(found.front().frames, 2U);
    EXPECT_EQ(found.front().last_at, std::chrono::milliseconds(1));
}

TEST(DroneCanExplainer, AFrameOutOfTurnDoesNoHarmIfAllFramesCome) {
    auto disordered = kRcInput;
    disordered.insert(disordered.begin() + 1, kRcInput[4]);
    EXPECT_EQ(faults(explained(disordered)), Faults{TransferFault::none});
}

TEST(DroneCanExplainer, WithoutItsFirstFrameATransferIsOneBrokenTransfer) {
    const auto found = explained(joined(without(kRcInput, 0), kFailsafe));
    ASSERT_EQ(faults(found), (Faults{TransferFault::start_missing, TransferFault::none}));
    EXPECT_EQ(found.front().frames, 4U);
    EXPECT_EQ(found.front().head.transfer_id, 5);
}

TEST(DroneCanExplainer, WithoutItsLastFrameATransferBrokeOffWhenTheNextOneBegins) {
    const auto found = explained(joined(without(kRcInput, 4), kFailsafe));
    ASSERT_EQ(faults(found), (Faults{TransferFault::broke_off, TransferFault::none}));
    EXPECT_EQ(found.front().frames, 4U);
    EXPECT_EQ(found.front().head.transfer_id, 5);
    EXPECT_EQ(found.front().last_at, std::chrono::milliseconds(3));
}

TEST(DroneCanExplainer, TheEndOfTheRecordingCutsATransferUnlessItWasOverBefore) {
    EXPECT_EQ(faults(explained(without(kRcInput, 4))), Faults{TransferFault::cut});
    EXPECT_EQ(faults(explained({kRcInput[0], "1801552A#D2040000000000CC"}, nullptr,
                               std::chrono::seconds(3))),
              (Faults{TransferFault::none, TransferFault::broke_off}));
}

TEST(DroneCanExplainer, ATransferSentAgainIsSaidToBeRepeatedAndACopiedFrameIsOnlyCounted) {
    TransferTally tally;
    EXPECT_EQ(faults(explained(joined(kRcInput, kRcInput), &tally)),
              (Faults{TransferFault::none, TransferFault::repeated}));
    EXPECT_EQ(tally.repeated_frames, 5U);
    auto copied = kRcInput;
    copied.insert(copied.begin() + 1, kRcInput[1]);
    EXPECT_EQ(faults(explained(copied, &tally)), Faults{TransferFault::none});
    EXPECT_EQ(tally.repeated_frames, 1U);
    // NodeStatus in one frame, the fifth worked example.
    EXPECT_EQ(faults(explained({"1801552A#D2040000000000CC", "1801552A#D2040000000000CC"})),
              (Faults{TransferFault::none, TransferFault::repeated}));
}

TEST(DroneCanExplainer, MoreThanTheTypeCanHaveIsTooLong) {
    EXPECT_EQ(faults(explained({"1801552A#AAAAD20400000080", "1801552A#0000000000000020",
                                "1801552A#0000000000000000", "1801552A#0060"})),
              Faults{TransferFault::too_long});
}

TEST(DroneCanExplainer, APayloadThatTheTypeCannotHaveIsAWrongLayout) {
    EXPECT_EQ(faults(explained({"1801552A#D204000000CC"})), Faults{TransferFault::layout});
}

TEST(DroneCanExplainer, TypesThatAreNotKnownHaveTheirPayloadAndNobodyCanCheckTheirCrc) {
    const auto single = explained({"1004D22A#010203C0"});
    ASSERT_EQ(faults(single), Faults{TransferFault::none});
    EXPECT_EQ(single.front().type, nullptr);
    EXPECT_EQ(single.front().head.data_type_id, 1234);
    EXPECT_EQ(single.front().payload, (Bytes{1, 2, 3}));
    EXPECT_FALSE(single.front().crc_unchecked);
    const auto several = explained({"1004D22A#AAAA010203040580", "1004D22A#0660"});
    ASSERT_EQ(faults(several), Faults{TransferFault::none});
    EXPECT_EQ(several.front().payload, (Bytes{1, 2, 3, 4, 5, 6}));
    EXPECT_TRUE(several.front().crc_unchecked);
}

TEST(DroneCanExplainer, FramesOfTwoNodesMayAlternate) {
    std::vector<std::string> frames;
    for (std::size_t at = 0; at < kRcInput.size(); ++at) {
        frames.push_back(kRcInput[at]);
        frames.push_back("0804742B" + kFailsafe[at].substr(8));
    }
    EXPECT_EQ(faults(explained(frames)), (Faults{TransferFault::none, TransferFault::none}));
}

TEST(DroneCanExplainer, AResponseIsPairedWithItsRequest) {
    TransferTally tally;
    // GetSet with an empty name: node 127 asks node 42 for service 11, which answers "no such
    // parameter".
    const auto found = explained({"180BAAFF#0000C3", "180B7FAA#00000000C3"}, &tally);
    ASSERT_EQ(found.size(), 2U);
    EXPECT_FALSE(found[0].answered_after);
    EXPECT_EQ(found[1].fault, TransferFault::none);
    EXPECT_EQ(found[1].answered_after, std::chrono::milliseconds(1));
    EXPECT_EQ(tally.answered, 1U);
}

TEST(DroneCanExplainer, AResponseWithAnotherTransferIdAnswersNothing) {
    TransferTally tally;
    const auto found = explained({"180BAAFF#0000C3", "180B7FAA#00000000C4"}, &tally);
    ASSERT_EQ(found.size(), 2U);
    EXPECT_FALSE(found[1].answered_after);
    EXPECT_EQ(tally.requests, 1U);
    EXPECT_EQ(tally.responses, 1U);
    EXPECT_EQ(tally.answered, 0U);
}

TEST(DroneCanExplainer, FramesOfOtherProtocolsAreCountedAndNothingElse) {
    TransferTally tally;
    EXPECT_TRUE(explained({"123#1122", "0804742A#", "0804742A#R"}, &tally).empty());
    EXPECT_EQ(tally.can_frames, 3U);
    EXPECT_EQ(tally.other_can_frames, 3U);
}

TEST(DroneCanExplainer, MoreSendersAndTypesThanThereIsRoomForAreCrowdedOutUntilOthersAreSilent) {
    constexpr char kDigits[] = "0123456789ABCDEF";
    std::vector<std::string> frames;
    for (unsigned type = 0; type <= 4096; ++type) {
        const unsigned id = 0x10000000U | (2000 + type) << 8U | 42U;
        std::string text;
        for (int shift = 28; shift >= 0; shift -= 4) {
            text += kDigits[id >> static_cast<unsigned>(shift) & 0xFU];
        }
        frames.push_back(text + "#01C0");
    }
    TransferTally tally;
    explained(frames, &tally, microseconds(1));
    EXPECT_EQ(tally.counts[static_cast<std::size_t>(TransferFault::none)], 4096U);
    EXPECT_EQ(tally.counts[static_cast<std::size_t>(TransferFault::crowded_out)], 1U);
    explained(frames, &tally, std::chrono::milliseconds(1));
    EXPECT_EQ(tally.counts[static_cast<std::size_t>(TransferFault::none)], 4097U);
}

}  // namespace
}  // namespace tribus::dronecan_explainer_test
