#include "transports/links/twins/faulty_link.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "transports/links/twins/memory_link.h"

namespace tribus::faulty_link_test {
namespace {

using namespace std::chrono_literals;
using Bytes = std::vector<std::uint8_t>;

Bytes bytes_of(std::span<const std::uint8_t> view) {
    return {view.begin(), view.end()};
}

const Bytes some_burst{0x20, 0x40, 0xDC, 0x05, 0x00, 0xFF, 0x0F, 0x55};

Reception injected(const FaultSettings& settings, std::uint64_t seed,
                   const Bytes& bytes = some_burst) {
    FaultInjector injector(settings, seed);
    Reception out;
    injector.apply(bytes, out);
    return out;
}

/// Returns how often `happened` is true in 10000 seeds.
template <class Happened>
int count_in_10000_seeds(Happened happened) {
    int count = 0;
    for (std::uint64_t seed = 0; seed < 10000; ++seed) {
        count += happened(seed) ? 1 : 0;
    }
    return count;
}

TEST(FaultInjectorTest, ChangesNothingWithoutFaults) {
    for (std::uint64_t seed = 0; seed < 1000; ++seed) {
        const Reception out = injected({}, seed);
        ASSERT_EQ(bytes_of(out.view()), some_burst);
        ASSERT_TRUE(out.damaged.none());
    }
}

TEST(FaultInjectorTest, LosesEveryByteIfAsked) {
    EXPECT_EQ(injected({.lose_byte = 1}, 1).count, 0U);
}

TEST(FaultInjectorTest, FlipsExactlyOneBitOfEveryByteIfAsked) {
    for (std::uint64_t seed = 0; seed < 100; ++seed) {
        const Reception out = injected({.flip_bit = 1}, seed);
        ASSERT_EQ(out.count, some_burst.size());
        ASSERT_TRUE(out.damaged.none());
        for (std::size_t i = 0; i < some_burst.size(); ++i) {
            ASSERT_EQ(std::popcount(static_cast<unsigned>(out.bytes[i] ^ some_burst[i])), 1);
        }
    }
}

TEST(FaultInjectorTest, MarksAndSpoilsEveryByteIfAsked) {
    const Reception out = injected({.damage_byte = 1}, 1);
    ASSERT_EQ(out.count, some_burst.size());
    EXPECT_EQ(out.damaged.count(), some_burst.size());
    for (std::size_t i = 0; i < some_burst.size(); ++i) {
        EXPECT_NE(out.bytes[i], some_burst[i]);
    }
}

TEST(FaultInjectorTest, AddsAByteBeforeEveryByteIfAsked) {
    const Reception out = injected({.add_byte = 1}, 1);
    ASSERT_EQ(out.count, 2 * some_burst.size());
    for (std::size_t i = 0; i < some_burst.size(); ++i) {
        EXPECT_EQ(out.bytes[2 * i + 1], some_burst[i]);
    }
}

TEST(FaultInjectorTest, KeepsTheDamageThatWasThereBefore) {
    Reception in;
    in.count = 3;
    in.damaged.set(1);
    FaultInjector injector({}, 1);
    Reception out;
    injector.apply(in, out);
    EXPECT_EQ(out.damaged.to_ullong(), 0b010U);
}

TEST(FaultInjectorTest, LosesWhatDoesNotFit) {
    const Reception out = injected({.add_byte = 1}, 1, Bytes(kBytesPerRead, 0x11));
    EXPECT_EQ(out.count, kBytesPerRead);
}

TEST(FaultInjectorTest, CutsTheHeadOrTheTailOffEveryBurstIfAsked) {
    int heads = 0;
    for (std::uint64_t seed = 0; seed < 1000; ++seed) {
        const Bytes left = bytes_of(injected({.cut_frame = 1}, seed).view());
        const bool head_lost = std::ranges::equal(left, std::span(some_burst).last(left.size()));
        ASSERT_TRUE(head_lost ||
                    std::ranges::equal(left, std::span(some_burst).first(left.size())));
        heads += head_lost && !left.empty() ? 1 : 0;
    }
    EXPECT_NEAR(heads, 500, 80);
}

TEST(FaultInjectorTest, LosesUpToSoManyBytesInARow) {
    std::vector<int> seen(some_burst.size() + 1, 0);
    for (std::uint64_t seed = 0; seed < 10000; ++seed) {
        const Reception out = injected({.lose_byte = 0.002, .most_in_a_row = 3}, seed);
        ++seen[some_burst.size() - out.count];
    }
    // Each of the 8 bytes begins a loss with 0.2 %: 160 losses, a third of each length, except
    // those that the end of the burst shortens.
    EXPECT_NEAR(seen[1], 60, 30);
    EXPECT_NEAR(seen[2], 53, 30);
    EXPECT_NEAR(seen[3], 40, 30);
}

TEST(FaultInjectorTest, AddsUpToSoManyBytesInARow) {
    for (std::uint64_t seed = 0; seed < 1000; ++seed) {
        const std::size_t count = injected({.add_byte = 1, .most_in_a_row = 4}, seed).count;
        ASSERT_GE(count, 2 * some_burst.size());
        ASSERT_LE(count, 5 * some_burst.size());
    }
}

// 5 % of 10000 is 500 with a standard deviation of 22.
TEST(FaultInjectorTest, FaultsAreAsFrequentAsAsked) {
    const Bytes one{0x20};
    const auto lost = [&](std::uint64_t seed) {
        return injected({.lose_byte = 0.05}, seed, one).count == 0;
    };
    const auto dropped = [](std::uint64_t seed) {
        return FaultInjector({.drop_frame = 0.05}, seed).drop_frame();
    };
    EXPECT_NEAR(count_in_10000_seeds(lost), 500, 100);
    EXPECT_NEAR(count_in_10000_seeds(dropped), 500, 100);
}

TEST(FaultInjectorTest, DelaysLieBetweenNothingAndTheMost) {
    FaultInjector injector({.most_delay = 3ns}, 1);
    std::vector<int> seen(4, 0);
    for (int i = 0; i < 1000; ++i) {
        const Duration delay = injector.next_delay();
        ASSERT_GE(delay, 0ns);
        ASSERT_LE(delay, 3ns);
        ++seen[static_cast<std::size_t>(delay.count())];
    }
    for (const int count : seen) {
        EXPECT_NEAR(count, 250, 80);
    }
}

TEST(FaultInjectorTest, HasNoDelayUnlessAsked) {
    EXPECT_EQ(FaultInjector({}, 1).next_delay(), 0ns);
}

constexpr FaultSettings kEveryFault{.lose_byte = 0.1,
                                    .flip_bit = 0.1,
                                    .add_byte = 0.1,
                                    .damage_byte = 0.1,
                                    .drop_frame = 0.1,
                                    .most_delay = 1ms};

TEST(FaultInjectorTest, TheSameSeedGivesTheSameFaults) {
    FaultInjector one(kEveryFault, 4711);
    FaultInjector other(kEveryFault, 4711);
    for (int burst = 0; burst < 1000; ++burst) {
        Reception of_one;
        Reception of_other;
        one.apply(some_burst, of_one);
        other.apply(some_burst, of_other);
        ASSERT_EQ(bytes_of(of_one.view()), bytes_of(of_other.view()));
        ASSERT_EQ(of_one.damaged, of_other.damaged);
        ASSERT_EQ(one.next_delay(), other.next_delay());
        ASSERT_EQ(one.drop_frame(), other.drop_frame());
    }
}

TEST(FaultInjectorTest, OtherSeedsGiveOtherFaults) {
    const Bytes burst(64, 0x20);
    EXPECT_NE(bytes_of(injected(kEveryFault, 1, burst).view()),
              bytes_of(injected(kEveryFault, 2, burst).view()));
}

// Outputs of splitmix64.c by Sebastiano Vigna (public domain) for seed 1234567:
// 6457827717110365317, 3203168211198807973, 9817491932198370423. A stored seed must give the same
// faults on every machine.
TEST(FaultInjectorTest, DelaysOfAKnownSeedAreTheKnownOnes) {
    constexpr std::int64_t kChoices = 1'000'000;
    FaultInjector injector({.most_delay = Duration(kChoices - 1)}, 1234567);
    EXPECT_EQ(injector.next_delay(), Duration(365317));
    EXPECT_EQ(injector.next_delay(), Duration(807973));
    EXPECT_EQ(injector.next_delay(), Duration(370423));
}

TEST(FaultyLinkTest, PassesBothWaysWithoutFaults) {
    MemoryLink inner;
    FaultyLink link(inner, {}, 1);
    inner.send(some_burst);
    Reception reception;
    EXPECT_EQ(link.read(reception), ReadStatus::received);
    EXPECT_EQ(bytes_of(reception.view()), some_burst);
    EXPECT_EQ(link.write(some_burst), WriteStatus::written);
    EXPECT_EQ(bytes_of(inner.written()), some_burst);
}

TEST(FaultyLinkTest, SpoilsWhatIsReadAndWhatIsWritten) {
    MemoryLink inner;
    FaultyLink link(inner, {.flip_bit = 1}, 1);
    inner.send(some_burst);
    Reception reception;
    link.read(reception);
    EXPECT_NE(bytes_of(reception.view()), some_burst);
    link.write(some_burst);
    EXPECT_NE(bytes_of(inner.written()), some_burst);
}

TEST(FaultyLinkTest, ABurstThatIsGoneReadsAsNothing) {
    MemoryLink inner;
    FaultyLink link(inner, {.drop_frame = 1}, 1);
    inner.send(some_burst);
    Reception reception;
    EXPECT_EQ(link.read(reception), ReadStatus::nothing);
    EXPECT_EQ(reception.count, 0U);
}

TEST(FaultyLinkTest, AWriterDoesNotSeeThatItsFrameIsGone) {
    MemoryLink inner;
    FaultyLink dropping(inner, {.drop_frame = 1}, 1);
    FaultyLink losing(inner, {.lose_byte = 1}, 1);
    EXPECT_EQ(dropping.write(some_burst), WriteStatus::written);
    EXPECT_EQ(losing.write(some_burst), WriteStatus::written);
    EXPECT_EQ(inner.frames_written(), 0U);
}

TEST(FaultyLinkTest, ReportsALostAndABusyLinkAsItIs) {
    MemoryLink inner;
    FaultyLink link(inner, {}, 1);
    inner.set_busy(true);
    EXPECT_EQ(link.write(some_burst), WriteStatus::busy);
    inner.set_lost(true);
    Reception reception;
    EXPECT_EQ(link.read(reception), ReadStatus::lost);
    EXPECT_EQ(link.write(some_burst), WriteStatus::lost);
}

ReceivedCanFrame some_can_frame() {
    ReceivedCanFrame received{.frame = {}, .at = Instant(5s)};
    received.frame.id = 0x300;
    received.frame.length = 4;
    received.frame.data = {0x20, 0x40, 0xDC, 0x05};
    return received;
}

CanReception injected_can(const CanFaultSettings& settings, std::uint64_t seed) {
    CanFaultInjector injector(settings, seed);
    CanReception out;
    injector.apply(some_can_frame(), out);
    return out;
}

TEST(CanFaultInjectorTest, ChangesNothingWithoutFaults) {
    for (std::uint64_t seed = 0; seed < 1000; ++seed) {
        const CanReception out = injected_can({.most_delay = 5ms}, seed);
        ASSERT_EQ(out.count, 1U);
        ASSERT_EQ(out.frames[0].frame, some_can_frame().frame);
        ASSERT_EQ(out.frames[0].at, some_can_frame().at);
    }
}

TEST(CanFaultInjectorTest, LosesOrDoublesEveryFrameIfAsked) {
    EXPECT_EQ(injected_can({.lose_frame = 1, .duplicate_frame = 1}, 1).count, 0U);
    const CanReception twice = injected_can({.duplicate_frame = 1}, 1);
    ASSERT_EQ(twice.count, 2U);
    EXPECT_EQ(twice.frames[0].frame, twice.frames[1].frame);
}

TEST(CanFaultInjectorTest, FlipsExactlyOneBitOfTheDataIfAsked) {
    for (std::uint64_t seed = 0; seed < 100; ++seed) {
        const CanReception out = injected_can({.flip_bit = 1}, seed);
        ASSERT_EQ(out.count, 1U);
        const CanFrame sound = some_can_frame().frame;
        int flipped = 0;
        for (std::size_t i = 0; i < sound.data.size(); ++i) {
            const auto difference =
                static_cast<unsigned>(sound.data[i] ^ out.frames[0].frame.data[i]);
            flipped += std::popcount(difference);
            ASSERT_TRUE(difference == 0 || i < sound.length);
        }
        ASSERT_EQ(flipped, 1);
    }
}

TEST(CanFaultInjectorTest, DelaysALateFrameUpToTheMost) {
    Duration most{};
    for (std::uint64_t seed = 0; seed < 1000; ++seed) {
        const CanReception out = injected_can({.late_frame = 1, .most_delay = 5ms}, seed);
        const Duration delay = out.frames[0].at - some_can_frame().at;
        ASSERT_GE(delay, 0ms);
        ASSERT_LE(delay, 5ms);
        most = std::max(most, delay);
    }
    EXPECT_GT(most, 4900us);
}

TEST(CanFaultInjectorTest, LosesWhatThereIsNoRoomFor) {
    CanFaultInjector injector({.duplicate_frame = 1}, 1);
    CanReception out;
    out.count = out.frames.size() - 1;
    injector.apply(some_can_frame(), out);
    EXPECT_EQ(out.count, out.frames.size());
}

TEST(CanFaultInjectorTest, LosesAboutAsManyFramesAsAsked) {
    const int lost = count_in_10000_seeds(
        [](std::uint64_t seed) { return injected_can({.lose_frame = 0.2}, seed).count == 0; });
    EXPECT_NEAR(lost, 2000, 200);
}

}  // namespace
}  // namespace tribus::faulty_link_test
