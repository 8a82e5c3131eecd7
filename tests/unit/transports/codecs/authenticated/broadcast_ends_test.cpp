#include "transports/codecs/authenticated/broadcast_ends.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/stored_numbers.h"
#include "tests/unit/transports/codecs/authenticated/link_bench.h"
#include "transports/codecs/authenticated/classic_ends.h"
#include "transports/codecs/network/network.h"

/// Links with an epoch on each kind of frame.
namespace tribus::test::broadcast_ends_test {
namespace {

using namespace std::chrono_literals;
using namespace authenticated;

using authenticated_link::at;
using authenticated_link::sticks;
using Frames = std::vector<CanFrame>;

LinkWithKey keys() {
    return {.name = std::string(authenticated_link::kLink),
            .secret = authenticated_link::counted_secret(),
            .epoch = "/not/read/by/codecs"};
}
FdLink fd_link() {
    return {.keys = keys(), .sender_id = 0x305, .receiver_id = 0x300};
}
ClassicLink classic_link() {
    return {.keys = keys(), .first_id = 0x300};
}

/// Both ends on CAN, and their numbers.
struct Ends {
    Ends(std::unique_ptr<CanEncoder> sends, std::unique_ptr<CanDecoder> receives)
        : encoder(std::move(sends)), decoder(std::move(receives)) {
        encoder->use_numbers(sent);
        decoder->use_numbers(received);
        // Both ends ask for numbers, and get them.
        write(at(-20ms));
        store();
        read(write(at(-10ms)), at(-10ms));
        store();
    }
    static Ends on_fd() { return {make_fd_encoder(fd_link()), make_fd_decoder(fd_link())}; }
    static Ends on_classic() {
        return {std::make_unique<ClassicEncoder>(classic_link()),
                std::make_unique<ClassicDecoder>(classic_link())};
    }

    Frames write(Instant now) const {
        std::array<CanFrame, kMostSnapshotFrames> frames{};
        const std::size_t count = encoder->write(sticks(now - 1500us), frames, now);
        return {frames.begin(), frames.begin() + static_cast<std::ptrdiff_t>(count)};
    }
    std::optional<ChannelFrame> read(const Frames& frames, Instant now) const {
        std::optional<ChannelFrame> snapshot;
        for (const CanFrame& frame : frames) {
            snapshot = decoder->next(frame, now);
        }
        return snapshot;
    }
    void store() {
        sent.store();
        received.store();
    }

    std::unique_ptr<CanEncoder> encoder;
    std::unique_ptr<CanDecoder> decoder;
    StoredNumbers sent{1000};
    StoredNumbers received{0};
};

TEST(BroadcastEnds, OnFdSendOneFrameASnapshot) {
    const Ends ends = Ends::on_fd();
    const Frames frames = ends.write(at(0ms));
    ASSERT_EQ(frames.size(), 1U);
    EXPECT_EQ(frames.front().id, 0x305U);
    EXPECT_TRUE(frames.front().fd);
    EXPECT_EQ(frames.front().length, 64U);
    const auto snapshot = ends.read(frames, at(0ms));
    ASSERT_TRUE(snapshot);
    EXPECT_TRUE(snapshot->same_content(sticks(at(0ms))));
}

TEST(BroadcastEnds, OnClassicCanSendEightFramesASnapshot) {
    const Ends ends = Ends::on_classic();
    const Frames frames = ends.write(at(0ms));
    ASSERT_EQ(frames.size(), 8U);
    for (std::size_t i = 0; i < frames.size(); ++i) {
        EXPECT_EQ(frames[i].id, 0x300U + i);
        EXPECT_EQ(frames[i].length, 8U);
    }
    const auto snapshot = ends.read(frames, at(0ms));
    ASSERT_TRUE(snapshot);
    EXPECT_TRUE(snapshot->same_content(sticks(at(0ms))));
}

TEST(BroadcastEnds, NeitherAnswerNorHearAnswers) {
    for (const Ends& ends : {Ends::on_fd(), Ends::on_classic()}) {
        EXPECT_TRUE(ends.decoder->answered().empty());
        EXPECT_TRUE(ends.decoder->answer(at(1s)).empty());
        EXPECT_TRUE(ends.encoder->heard().empty());
    }
}

TEST(BroadcastEnds, WithholdChannelsThatNoStoredNumberIsLeftFor) {
    for (Ends& ends : std::array{Ends::on_fd(), Ends::on_classic()}) {
        EXPECT_EQ(ends.write(at(12h)), Frames{});
        EXPECT_EQ(ends.encoder->withheld(), Withheld::no_numbers);
        ends.store();
        EXPECT_NE(ends.write(at(12h)), Frames{});
        EXPECT_EQ(ends.encoder->withheld(), Withheld::nothing);
    }
}

TEST(BroadcastEnds, SayWhyTheyRefuse) {
    const Ends ends = Ends::on_fd();
    const Frames snapshot = ends.write(at(0ms));
    EXPECT_TRUE(ends.read(snapshot, at(0ms)));
    EXPECT_FALSE(ends.read(snapshot, at(1ms)));
    EXPECT_EQ(ends.decoder->why_garbled(), LinkCause::replayed);
    Frames wrong = ends.write(at(10ms));
    wrong.front().data[12] ^= 1U;
    EXPECT_FALSE(ends.read(wrong, at(10ms)));
    EXPECT_EQ(ends.decoder->why_garbled(), LinkCause::forged);
}

TEST(BroadcastEnds, TakeNothingOfAnotherIdOrKindOfFrame) {
    const Ends ends = Ends::on_fd();
    Frames frames = ends.write(at(0ms));
    frames.front().id = 0x304;
    EXPECT_FALSE(ends.read(frames, at(0ms)));
    frames.front().id = 0x305;
    frames.front().fd = false;
    EXPECT_FALSE(ends.read(frames, at(0ms)));
    frames.front().fd = true;
    EXPECT_TRUE(ends.read(frames, at(0ms)));
}

/// Else the snapshots of the new configuration would seem to come late.
TEST(BroadcastEnds, GoOnWithTheirClockAfterAReload) {
    Ends ends = Ends::on_fd();
    for (Duration now = 0ms; now < 1s; now += 10ms) {
        EXPECT_TRUE(ends.read(ends.write(at(now)), at(now)));
    }
    auto next = make_fd_encoder(fd_link());
    next->use_numbers(ends.sent);
    next->continue_from(*ends.encoder);
    ends.encoder = std::move(next);
    const auto snapshot = ends.read(ends.write(at(1s + 90ms)), at(1s + 90ms));
    ASSERT_TRUE(snapshot);
    EXPECT_GE(snapshot->received, at(1s + 90ms) - 1500us - 10us);
}

TEST(BroadcastEnds, AreTheSameInDatagrams) {
    StoredNumbers sent(1000);
    StoredNumbers received(0);
    NetworkEncoder encoder(make_fd_encoder(fd_link()));
    NetworkDecoder decoder(make_fd_decoder(fd_link()));
    encoder.use_numbers(sent);
    decoder.use_numbers(received);
    std::size_t read = 0;
    for (Duration now = 0ms; now < 50ms; now += 10ms) {
        std::array<std::uint8_t, kLongestSerialFrame> wire{};
        std::span<const std::uint8_t> bytes(wire.data(),
                                            encoder.write(sticks(at(now)), wire, at(now)));
        DecodedFrame frame;
        read += decoder.next(bytes, at(now), frame) ? 1U : 0U;
        EXPECT_TRUE(decoder.answer(at(now)).empty());
        sent.store();
        received.store();
    }
    EXPECT_EQ(read, 3U) << "all but those until both ends had numbers";
    EXPECT_TRUE(encoder.may_withhold());
    EXPECT_EQ(encoder.withheld(), Withheld::nothing);
}

}  // namespace
}  // namespace tribus::test::broadcast_ends_test
