#include "transports/codecs/authenticated/broadcast.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/stored_numbers.h"
#include "tests/support/streams.h"
#include "tests/unit/transports/codecs/authenticated/link_bench.h"

/// Snapshots with a key for receivers that do not answer.
namespace tribus::test::broadcast_test {
namespace {

using namespace std::chrono_literals;
using namespace authenticated;

using authenticated_link::at;
using authenticated_link::sticks;
using Message = std::vector<std::uint8_t>;

constexpr std::uint64_t kFirst = 0x0102030405060708;
/// Computed as those of link_bench.h.
constexpr std::string_view kDigits =
    "106196000807060504030201401fd0206022f02380251027a028302ac02b502de02e7030003290332035b036"
    "ffffffff1a171a4a98a4076e4ecf2f485b240028";

/// What version 0 sent in its place, with Poly1305-AES.
constexpr std::string_view kDigitsOfVersion0 =
    "006196000807060504030201401fd0206022f02380251027a028302ac02b502de02e7030003290332035b036"
    "ffffffff2efd7ea71674a4a9577a87da1c18fae9";

Mac keys(std::string_view link = authenticated_link::kLink) {
    return Mac(link_key(authenticated_link::counted_secret(), Purpose::broadcast, link));
}

class Broadcast : public ::testing::Test {
  protected:
    Broadcast() {
        sender_.use_numbers(sent_);
        receiver_.use_numbers(received_);
        // Both ends ask for numbers, and get them.
        write(at(-20ms));
        store();
        read(write(at(-10ms)), at(-10ms));
        store();
    }

    Message write(Instant now) {
        SnapshotMessage message{};
        const bool written = sender_.write(sticks(now - 1500us), message, now);
        return written ? Message{message.begin(), message.end()} : Message{};
    }
    std::optional<ChannelFrame> read(const Message& message, Instant now) {
        return receiver_.next(message, now);
    }
    std::uint64_t rejected(std::string_view name) const {
        return std::ranges::find(receiver_.rejected(), name, &NamedCount::name)->count;
    }
    void store() {
        sent_.store();
        received_.store();
    }
    void restart_receiver() {
        receiver_ = BroadcastReceiver(keys(), std::nullopt);
        received_.start(Instant{});
        receiver_.use_numbers(received_);
    }
    void restart_sender(Instant now) {
        sender_ = BroadcastSender(keys());
        sent_.start(now);
        sender_.use_numbers(sent_);
    }

    StoredNumbers sent_{1000};
    StoredNumbers received_{0};
    BroadcastSender sender_{keys()};
    BroadcastReceiver receiver_{keys(), std::nullopt};
};

TEST_F(Broadcast, SendsTheseBytes) {
    StoredNumbers file{kFirst};
    BroadcastSender sender(keys());
    sender.use_numbers(file);
    SnapshotMessage message{};
    EXPECT_FALSE(sender.write(sticks(at(0ms)), message, at(0ms))) << "no number is stored";
    file.store();
    ASSERT_TRUE(sender.write(sticks(at(0ms) - 1500us), message, at(0ms)));
    EXPECT_EQ((Message{message.begin(), message.end()}), from_hex(kDigits));
}

TEST_F(Broadcast, SendsNothingWithoutItsFile) {
    BroadcastSender sender(keys());
    SnapshotMessage message{};
    EXPECT_FALSE(sender.write(sticks(at(0ms)), message, at(0ms)));
}

TEST_F(Broadcast, PublishesWhatWasSent) {
    const auto frame = read(write(at(0ms)), at(0ms));
    ASSERT_TRUE(frame);
    EXPECT_TRUE(frame->same_content(sticks(at(0ms))));
    EXPECT_EQ(frame->received, at(0ms) - 1500us);
}

TEST_F(Broadcast, PublishesNothingBeforeItsNumberIsStored) {
    StoredNumbers file{0};
    BroadcastReceiver receiver(keys(), std::nullopt);
    receiver.use_numbers(file);
    const Message message = write(at(0ms));
    EXPECT_FALSE(receiver.next(message, at(0ms)));
    EXPECT_FALSE(receiver.next(message, at(1ms))) << "nor later, as long as it is not";
    file.store();
    EXPECT_TRUE(receiver.next(message, at(2ms)));
}

TEST_F(Broadcast, PublishesEachSnapshotOnceAndNoneAfterANewerOne) {
    const Message one = write(at(0ms));
    const Message two = write(at(10ms));
    const Message three = write(at(20ms));
    EXPECT_TRUE(read(two, at(20ms)));
    EXPECT_FALSE(read(one, at(20ms)));
    EXPECT_FALSE(read(two, at(20ms)));
    EXPECT_TRUE(read(three, at(20ms)));
    EXPECT_EQ(rejected("replayed"), 2U);
}

TEST_F(Broadcast, PublishesNothingFromBeforeItStartedAgain) {
    std::vector<Message> recorded;
    for (Duration now = 0ms; now < 30s; now += 10ms) {
        recorded.push_back(write(at(now)));
        EXPECT_TRUE(read(recorded.back(), at(now)));
        store();
    }
    restart_receiver();
    for (const Message& message : recorded) {
        EXPECT_FALSE(read(message, at(30s)));
        store();
    }
    EXPECT_EQ(rejected("replayed"), recorded.size());
}

/// A killed receiver does not know what it used of its reservation.
TEST_F(Broadcast, IsDeafForAtMost20SecondsAfterItWasKilled) {
    EXPECT_TRUE(read(write(at(0ms)), at(0ms)));
    restart_receiver();
    Duration heard{};
    for (Duration now = 0ms; now < 30s && heard == 0ms; now += 10ms) {
        heard = read(write(at(now)), at(now)) ? now : 0ms;
        store();
    }
    EXPECT_GT(heard, 10s);
    EXPECT_LE(heard, 20s + 20ms);
}

TEST_F(Broadcast, IsHeardAtOnceAfterItsSenderStartedAgain) {
    EXPECT_TRUE(read(write(at(0ms)), at(0ms)));
    restart_sender(at(10ms));
    EXPECT_TRUE(read(write(at(10ms)), at(10ms)));
}

/// The age of its first snapshot is known, as if it had gone on.
TEST_F(Broadcast, KnowsTheTimeForWhichItsSenderWasAway) {
    Duration now = 0ms;
    for (const Duration away : {Duration(100ms), Duration(1s), Duration(60s), Duration(13h)}) {
        for (const bool in_order : {true, false}) {
            EXPECT_TRUE(read(write(at(now)), at(now)));
            store();
            if (in_order) {
                sent_.stop();
            }
            now += away;
            restart_sender(at(now));
            write(at(now));
            store();
            read(write(at(now)), at(now + 300ms));
            store();
            const auto late = read(write(at(now + 10ms)), at(now + 310ms));
            store();
            ASSERT_TRUE(late);
            EXPECT_LE(late->received, at(now + 10ms) - 1500us + away / 5000 + 1ms);
            const auto quick = read(write(at(now + 320ms)), at(now + 320ms));
            ASSERT_TRUE(quick);
            EXPECT_GE(quick->received, at(now + 320ms) - 1500us - 1ms);
            now += 1s;
        }
    }
}

/// Nobody knows for how long it was away. What is held back from then on is not seen.
TEST_F(Broadcast, TakesTheFirstSnapshotByAnotherClockForTheQuickest) {
    EXPECT_TRUE(read(write(at(0ms)), at(0ms)));
    sent_.lose_clock(at(10s));
    restart_sender(at(10s));
    write(at(10s));
    store();
    EXPECT_FALSE(read(write(at(10s)), at(100s))) << "the receiver has not stored its number yet";
    store();
    const auto first = read(write(at(10s + 10ms)), at(100s + 10ms));
    ASSERT_TRUE(first);
    EXPECT_EQ(first->received, at(100s + 10ms) - 1500us);
}

/// The clock stood still meanwhile.
TEST_F(Broadcast, IsHeardAgainWhereItsSenderWasSuspended) {
    EXPECT_TRUE(read(write(at(0ms)), at(0ms)));
    const auto before = read(write(at(10ms)), at(60s));
    ASSERT_TRUE(before);
    EXPECT_LT(before->received, at(13s)) << "it cannot know that nobody held it back";
    sent_.lose_clock(at(20ms));
    EXPECT_TRUE(write(at(20ms)).empty()) << "its number is not stored yet";
    store();
    read(write(at(30ms)), at(60s + 20ms));
    store();
    const auto after = read(write(at(40ms)), at(60s + 30ms));
    ASSERT_TRUE(after);
    EXPECT_EQ(after->received, at(60s + 30ms) - 1500us);
}

/// Snapshots that nobody heard, the last one before an orderly end among them.
TEST_F(Broadcast, KnowsTheAgeOfWhatAFormerRunSent) {
    EXPECT_TRUE(read(write(at(0ms)), at(0ms)));
    std::vector<Message> kept;
    Duration now = 10ms;
    for (int run = 0; run < 3; ++run) {
        for (int i = 0; i < 100; ++i) {
            kept.push_back(write(at(now)));
            now += 10ms;
        }
        store();
        sent_.stop();
        now += 2s;
        restart_sender(at(now));
        write(at(now));
        store();
    }
    for (const Message& message : kept) {
        const auto frame = read(message, at(now));
        store();
        if (frame) {
            EXPECT_LT(frame->received, at(now - 1s));
        }
    }
    EXPECT_TRUE(read(write(at(now)), at(now)));
    const std::uint64_t replayed = rejected("replayed");
    for (const Message& message : kept) {
        EXPECT_FALSE(read(message, at(now)));
    }
    EXPECT_EQ(rejected("replayed"), replayed + kept.size());
}

TEST_F(Broadcast, RefusesEverySnapshotWithAChangedBitOrACut) {
    const Message right = write(at(0ms));
    for (std::size_t bit = 0; bit < 8 * right.size(); ++bit) {
        Message wrong = right;
        wrong[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
        EXPECT_FALSE(read(wrong, at(0ms))) << bit;
    }
    EXPECT_EQ(rejected("other_version"), 4U) << "the bits of the version";
    EXPECT_EQ(rejected("forged") + 4, 8 * right.size());
    for (std::size_t length = 0; length < right.size(); ++length) {
        EXPECT_FALSE(
            read({right.begin(), right.begin() + static_cast<std::ptrdiff_t>(length)}, at(0ms)));
    }
    EXPECT_EQ(rejected("no_key"), right.size());
    EXPECT_TRUE(read(right, at(0ms)));
}

TEST_F(Broadcast, RefusesAnotherLinkAndTakesAnOldKey) {
    const Message message = write(at(0ms));
    BroadcastReceiver other(keys("can 0x300 ship"), std::nullopt);
    other.use_numbers(received_);
    EXPECT_FALSE(other.next(message, at(0ms)));
    BroadcastReceiver changed(keys("can 0x300 ship"), keys());
    changed.use_numbers(received_);
    EXPECT_TRUE(changed.next(message, at(0ms)));
}

TEST_F(Broadcast, InAnotherVersionIsRefusedAndNamed) {
    std::array<char, 160> text{};
    EXPECT_FALSE(read(from_hex(kDigitsOfVersion0), at(0ms)));
    EXPECT_EQ(rejected("other_version"), 1U);
    EXPECT_EQ(receiver_.why_refused(), LinkCause::garbled);
    EXPECT_EQ(std::string_view(text.data(), receiver_.write_fault(text)),
              "snapshots of another version of tribus; give both ends the same one");
    EXPECT_TRUE(read(write(at(0ms)), at(0ms)));
    EXPECT_EQ(receiver_.write_fault(text), 0U);
}

/// A snapshot that the key's holder could send.
Message with_number(Mac key, std::uint64_t number) {
    Message message = from_hex(kDigits);
    for (std::size_t byte = 0; byte < 8; ++byte) {
        message[4 + byte] = static_cast<std::uint8_t>(number >> (8 * byte));
    }
    const auto mac = key.of(std::span(message).first(48));
    std::ranges::copy(mac, message.begin() + 48);
    return message;
}

TEST_F(Broadcast, RefusesNumbersThatNoSenderReaches) {
    for (const std::uint64_t number :
         {kEndOfNumbers, kEndOfNumbers + 5, 0 - std::uint64_t{1'500'000}, ~std::uint64_t{0}}) {
        EXPECT_FALSE(read(with_number(keys(), number), at(0ms))) << number;
        store();
        EXPECT_FALSE(read(with_number(keys(), number), at(0ms))) << number;
    }
    EXPECT_TRUE(read(write(at(10ms)), at(10ms))) << "they have used up nothing";
    const Message highest = with_number(keys(), kEndOfNumbers - 1);
    EXPECT_FALSE(read(highest, at(20ms)));
    store();
    EXPECT_TRUE(read(highest, at(20ms)));
    EXPECT_FALSE(read(highest, at(20ms)));
    EXPECT_FALSE(read(write(at(30ms)), at(30ms)));
}

/// Whoever has a stolen old key, while keys are changed, does not lock the new one out for ever.
TEST_F(Broadcast, WithTheOldKeyUsesUpNoNumberOfTheNewOne) {
    const Mac stolen = keys("stolen");
    const BroadcastReceiver changed(keys(), stolen);
    BroadcastReceiver fresh = changed;
    fresh.use_numbers(received_);
    receiver_.use_keys_of(fresh);
    EXPECT_TRUE(read(write(at(0ms)), at(0ms)));
    for (const std::uint64_t number : {std::uint64_t{1} << 40U, kEndOfNumbers - 1}) {
        const Message message = with_number(stolen, number);
        EXPECT_FALSE(read(message, at(1ms)));
        store();
        EXPECT_TRUE(read(message, at(1ms)));
        EXPECT_FALSE(read(message, at(1ms)));
    }
    const auto frame = read(write(at(10ms)), at(10ms));
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->received, at(10ms) - 1500us) << "nor does it look late";
    restart_receiver();
    EXPECT_FALSE(read(write(at(30s)), at(30s))) << "no number is stored";
    store();
    EXPECT_TRUE(read(write(at(31s)), at(31s))) << "nor after a restart";
}

/// The same sender, with the same clock: the new key does not make what is held back young.
TEST_F(Broadcast, KnowsTheDelayOverAChangeOfKeys) {
    EXPECT_TRUE(read(write(at(0ms)), at(0ms)));
    BroadcastReceiver fresh(keys("new"), keys());
    fresh.use_numbers(received_);
    receiver_.use_keys_of(fresh);
    sender_ = BroadcastSender(keys("new"));
    sender_.use_numbers(sent_);
    EXPECT_FALSE(read(write(at(10ms)), at(310ms))) << "no number is stored";
    store();
    const auto late = read(write(at(20ms)), at(320ms));
    ASSERT_TRUE(late);
    EXPECT_LE(late->received, at(20ms));
}

/// With the old key, so from before the change.
TEST_F(Broadcast, WithTheOldKeyIsNotTakenBehindTheNewOne) {
    const Message held_back = write(at(0ms));
    BroadcastReceiver fresh(keys("new"), keys());
    fresh.use_numbers(received_);
    receiver_.use_keys_of(fresh);
    sender_ = BroadcastSender(keys("new"));
    sender_.use_numbers(sent_);
    EXPECT_FALSE(read(write(at(10ms)), at(10ms))) << "no number is stored";
    store();
    EXPECT_TRUE(read(write(at(20ms)), at(20ms)));
    EXPECT_FALSE(read(held_back, at(21ms)));
}

TEST_F(Broadcast, TellsHowMuchLaterThanTheQuickestASnapshotCame) {
    for (Duration now = 0ms; now < 1s; now += 10ms) {
        EXPECT_TRUE(read(write(at(now)), at(now + 3ms)));
    }
    const auto late = read(write(at(1s)), at(1s + 303ms));
    ASSERT_TRUE(late);
    EXPECT_LE(late->received, at(1s + 3ms) - 1500us + 1ms);
    EXPECT_GE(late->received, at(1s + 3ms) - 1500us - 1ms);
}

/// One clock is 0.01 % faster than the other, either way, for an hour.
TEST_F(Broadcast, TakesClocksThatDriftForNoDelay) {
    for (const std::int64_t parts : {10'000, -10'000}) {
        for (Duration now = 0ms; now < 1h; now += 100ms) {
            const Instant arrival = at(now + now / parts);
            const auto frame = read(write(at(now)), arrival);
            store();
            ASSERT_TRUE(frame);
            ASSERT_LE(arrival - frame->received, 1500us + 100us);
        }
        sent_.lose_clock(at(0ms));
        restart_sender(at(0ms));
        write(at(0ms));
        store();
        read(write(at(0ms)), at(0ms));
        store();
    }
}

TEST_F(Broadcast, FallsSilentWhereNumbersAreUsedUpAndNoneAreStored) {
    EXPECT_FALSE(write(at(11h)).empty());
    EXPECT_TRUE(write(at(12h)).empty());
    store();
    EXPECT_FALSE(write(at(12h)).empty());
}

}  // namespace
}  // namespace tribus::test::broadcast_test
