#include "transports/codecs/authenticated/classic_ends.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/streams.h"
#include "tests/unit/transports/codecs/authenticated/link_bench.h"

/// The messages of an authenticated link in classic CAN frames.
namespace tribus::test::classic_ends_test {
namespace {

using namespace std::chrono_literals;
using namespace authenticated;

using authenticated_link::at;
using authenticated_link::sticks;
using Frames = std::vector<CanFrame>;

constexpr std::uint32_t kFirstSnapshotId = 0x300;
constexpr std::uint32_t kFirstHelloId = 0x308;
constexpr std::uint32_t kFirstChallengeId = 0x30B;

/// Each eight bytes in a frame, with ids in a row.
Frames frames_of(std::uint32_t first_id, std::string_view digits) {
    const Bytes bytes = from_hex(digits);
    Frames frames;
    for (std::size_t at = 0; at < bytes.size(); at += 8) {
        CanFrame frame{.id = first_id + static_cast<std::uint32_t>(at / 8), .length = 8};
        std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(at), 8, frame.data.begin());
        frames.push_back(frame);
    }
    return frames;
}

class ClassicEnds : public ::testing::Test {
  protected:
    ClassicEnds() {
        encoder_.use_seed(authenticated_link::seed_of(authenticated_link::kSession));
        decoder_.use_seed(authenticated_link::kSeed);
    }

    static ClassicLink link() {
        return {.keys = {.name = std::string(authenticated_link::kLink),
                         .secret = authenticated_link::counted_secret()},
                .first_id = kFirstSnapshotId};
    }
    Frames write(Instant now) {
        std::array<CanFrame, kMostSnapshotFrames> frames{};
        const std::size_t count = encoder_.write(sticks(now - 1500us), frames, now);
        return {frames.begin(), frames.begin() + static_cast<std::ptrdiff_t>(count)};
    }
    std::optional<ChannelFrame> read(const Frames& frames, Instant now) {
        std::optional<ChannelFrame> latest;
        for (const CanFrame& frame : frames) {
            if (const auto snapshot = decoder_.next(frame, now)) {
                EXPECT_FALSE(latest);
                latest = snapshot;
            }
        }
        return latest;
    }
    Frames answer(Instant now) {
        const auto frames = decoder_.answer(now);
        return {frames.begin(), frames.end()};
    }
    void hear(const Frames& frames, Instant now) {
        for (const CanFrame& frame : frames) {
            encoder_.hear(frame, now);
        }
    }
    /// Hello and answer, and the first snapshot.
    Frames first_snapshot() {
        read(write(at(0ms)), at(0ms));
        hear(answer(at(0ms)), at(0ms));
        return write(at(2ms));
    }
    std::uint64_t rejected(std::string_view name) const {
        return std::ranges::find(decoder_.rejected(), name, &NamedCount::name)->count;
    }

    ClassicEncoder encoder_{link()};
    ClassicDecoder decoder_{link()};
};

TEST_F(ClassicEnds, SayEachMessageInTheseFrames) {
    EXPECT_EQ(write(at(0ms)), frames_of(kFirstHelloId, authenticated_link::kHelloDigits));
    EXPECT_EQ(encoder_.withheld(), Withheld::no_receiver);
    hear(frames_of(kFirstChallengeId, authenticated_link::kChallengeDigits), at(0ms));
    EXPECT_EQ(write(at(2ms)), frames_of(kFirstSnapshotId, authenticated_link::kSnapshotDigits));
    EXPECT_EQ(encoder_.withheld(), Withheld::nothing);
}

TEST_F(ClassicEnds, AnswerAHelloAndPublishASnapshotWithItsLastFrame) {
    EXPECT_EQ(answer(at(0ms)), Frames{});
    EXPECT_FALSE(read(frames_of(kFirstHelloId, authenticated_link::kHelloDigits), at(0ms)));
    EXPECT_EQ(answer(at(0ms)), frames_of(kFirstChallengeId, authenticated_link::kChallengeDigits));
    const auto snapshot =
        read(frames_of(kFirstSnapshotId, authenticated_link::kSnapshotDigits), at(2ms));
    ASSERT_TRUE(snapshot);
    EXPECT_TRUE(snapshot->same_content(sticks(at(0ms))));
    EXPECT_LE(snapshot->received, at(500us)) << "never younger than it is";
    EXPECT_GE(snapshot->received, at(500us) - 30us);
}

TEST_F(ClassicEnds, NameTheIdsThatTheyReadAndSend) {
    const auto ids = [](std::span<const CanIdMatch> matches) {
        std::vector<std::uint32_t> all;
        for (const CanIdMatch& match : matches) {
            all.push_back(match.id);
        }
        return all;
    };
    const std::vector<std::uint32_t> of_sender{0x300, 0x301, 0x302, 0x303, 0x304, 0x305,
                                               0x306, 0x307, 0x308, 0x309, 0x30A};
    const std::vector<std::uint32_t> of_receiver{0x30B, 0x30C, 0x30D, 0x30E};
    EXPECT_EQ(ids(encoder_.sent()), of_sender);
    EXPECT_EQ(ids(decoder_.wanted()), of_sender);
    EXPECT_EQ(ids(encoder_.heard()), of_receiver);
    EXPECT_EQ(ids(decoder_.answered()), of_receiver);
}

TEST_F(ClassicEnds, LoseOneSnapshotWithEachLostFrame) {
    const Frames whole = first_snapshot();
    ASSERT_TRUE(read(whole, at(2ms)));
    Duration now = 2ms;
    for (std::size_t lost = 0; lost < whole.size(); ++lost) {
        now += 10ms;
        Frames rest = write(at(now));
        rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(lost));
        EXPECT_FALSE(read(rest, at(now))) << lost;
        now += 10ms;
        EXPECT_TRUE(read(write(at(now)), at(now))) << lost;
        hear(answer(at(now)), at(now));
        EXPECT_EQ(rejected("incomplete"), lost + 1);
    }
    EXPECT_EQ(rejected("forged"), 0U);
}

TEST_F(ClassicEnds, PublishNothingOutOfTwoSnapshotsOrInAnotherOrder) {
    ASSERT_TRUE(read(first_snapshot(), at(2ms)));
    const Frames one = write(at(12ms));
    const Frames two = write(at(22ms));
    // Both have the same first frame: session, challenge and age.
    for (std::size_t cut = 2; cut < one.size(); ++cut) {
        const auto place = static_cast<std::ptrdiff_t>(cut);
        Frames mixed(one.begin(), one.begin() + place);
        mixed.insert(mixed.end(), two.begin() + place, two.end());
        EXPECT_FALSE(read(mixed, at(22ms))) << cut;
        Frames turned = two;
        std::swap(turned[cut - 1], turned[cut]);
        EXPECT_FALSE(read(turned, at(22ms))) << cut;
        Frames doubled = two;
        doubled.insert(doubled.begin() + place, two[cut - 1]);
        EXPECT_FALSE(read(doubled, at(22ms))) << cut;
    }
    EXPECT_EQ(rejected("forged"), one.size() - 2);
    EXPECT_TRUE(read(two, at(22ms)));
}

TEST_F(ClassicEnds, TakeNoFrameOfAnotherKind) {
    const Frames whole = first_snapshot();
    for (std::size_t place = 0; place < whole.size(); ++place) {
        for (const auto change : {+[](CanFrame& frame) { frame.fd = true; },
                                  +[](CanFrame& frame) { frame.remote = true; },
                                  +[](CanFrame& frame) { frame.length = 7; },
                                  +[](CanFrame& frame) { frame.extended = true; }}) {
            Frames changed = whole;
            change(changed[place]);
            EXPECT_FALSE(read(changed, at(2ms))) << place;
        }
    }
    EXPECT_TRUE(read(whole, at(2ms)));
}

TEST_F(ClassicEnds, GoOnAfterAReloadUnlessTheKeyIsAnother) {
    ASSERT_TRUE(read(first_snapshot(), at(2ms)));
    ClassicLink other_link = link();
    other_link.keys.secret[0] ^= 1U;
    ClassicEncoder same(link());
    ClassicEncoder other(other_link);
    same.continue_from(encoder_);
    other.continue_from(encoder_);
    EXPECT_EQ(same.withheld(), Withheld::nothing);
    EXPECT_EQ(other.withheld(), Withheld::no_receiver);
    std::array<CanFrame, kMostSnapshotFrames> frames{};
    const std::size_t count = same.write(sticks(at(12ms)), frames, at(12ms));
    EXPECT_TRUE(
        read({frames.begin(), frames.begin() + static_cast<std::ptrdiff_t>(count)}, at(12ms)));
}

}  // namespace
}  // namespace tribus::test::classic_ends_test
