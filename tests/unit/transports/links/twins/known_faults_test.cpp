#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "transports/links/twins/faulty_link.h"
#include "transports/links/twins/memory_link.h"

/// Which faults a seed makes. They may not change: a stored seed is to give the same faults for
/// ever.
namespace tribus::test::known_faults_test {
namespace {

using namespace std::chrono_literals;
using Bytes = std::vector<std::uint8_t>;

constexpr std::uint64_t kSeed = 1234567;

/// Bytes in hexadecimal, with an x behind a damaged one, of three bursts of eight.
std::string faulty(const FaultSettings& settings, std::uint64_t seed = kSeed) {
    FaultInjector injector(settings, seed);
    std::string text;
    for (std::uint8_t burst = 0; burst < 3; ++burst) {
        Reception out;
        Bytes in;
        for (std::uint8_t byte = 0; byte < 8; ++byte) {
            in.push_back(static_cast<std::uint8_t>(0x10 * (burst + 1) + byte));
        }
        injector.apply(in, out);
        for (std::size_t i = 0; i < out.count; ++i) {
            text += fmt::format("{:02x}{}", out.bytes[i], out.damaged.test(i) ? "x" : "");
        }
        text += '|';
    }
    return text;
}

TEST(KnownFaults, LoseBytes) {
    EXPECT_EQ(faulty({.lose_byte = 0.3}), "1213|2122232426|3031323334353637|");
    EXPECT_EQ(faulty({.lose_byte = 0.2, .most_in_a_row = 3}),
              "1112131417|23242527|30323334353637|");
}

/// The end of a burst ends a loss, however long it was to be.
TEST(KnownFaults, LoseBytesUpToTheEndOfTheirBurst) {
    EXPECT_EQ(faulty({.lose_byte = 0.2, .most_in_a_row = 1000}), "|20|30|");
}

TEST(KnownFaults, AddBytes) {
    EXPECT_EQ(faulty({.add_byte = 0.3}),
              "10111213149c151617|202122cc2324252627|30313233cf34353637|");
    EXPECT_EQ(faulty({.add_byte = 0.2, .most_in_a_row = 2}),
              "1011121314f9151617|2021222324252627|30313233e00d34353637|");
}

TEST(KnownFaults, MakeBitsWrong) {
    EXPECT_EQ(faulty({.flip_bit = 0.4, .damage_byte = 0.4}),
              "30x1002x10x1495x1657x|203132xa3x24252637|3033323b30x2dx3677x|");
}

TEST(KnownFaults, CutBursts) {
    EXPECT_EQ(faulty({.cut_frame = 0.7}), "10111213141516|2021222324252627|3031323334|");
}

TEST(KnownFaults, MixAllKinds) {
    EXPECT_EQ(faulty({.lose_byte = 0.1,
                      .flip_bit = 0.1,
                      .add_byte = 0.1,
                      .damage_byte = 0.1,
                      .cut_frame = 0.5,
                      .most_in_a_row = 4}),
              "10111210xfdb5144affdf781516|21222324252627|3031323334e5923f253637|");
}

std::string faulty_can(const CanFaultSettings& settings, unsigned frames) {
    CanFaultInjector injector(settings, kSeed);
    CanReception out;
    for (unsigned i = 0; i < frames; ++i) {
        ReceivedCanFrame in{.frame = {}, .at = Instant(1000ns * i)};
        in.frame.length = static_cast<std::uint8_t>(i % 3);
        in.frame.data = {0x10, 0x20};
        injector.apply(in, out);
    }
    std::string text;
    for (std::size_t i = 0; i < out.count; ++i) {
        text += fmt::format("{}:{:02x}{:02x} ", out.frames[i].at.time_since_epoch().count(),
                            out.frames[i].frame.data[0], out.frames[i].frame.data[1]);
    }
    return text;
}

TEST(KnownFaults, HitFramesOfABus) {
    EXPECT_EQ(faulty_can({.lose_frame = 0.3}, 8),
              "0:1020 2000:1020 3000:1020 4000:1020 6000:1020 ");
    EXPECT_EQ(faulty_can({.duplicate_frame = 0.4}, 6),
              "0:1020 0:1020 1000:1020 2000:1020 3000:1020 3000:1020 4000:1020 4000:1020 "
              "5000:1020 ");
    EXPECT_EQ(faulty_can({.flip_bit = 0.6}, 9),
              "0:1020 1000:1220 2000:1022 3000:1020 4000:1220 5000:1020 6000:1020 7000:1020 "
              "8000:1220 ");
    EXPECT_EQ(faulty_can({.late_frame = 0.5, .most_delay = 900ns}, 6),
              "0:1020 1000:1020 2464:1020 3103:1020 4187:1020 5000:1020 ");
}

/// Before this seed SplitMix64 comes to 0, its least number.
TEST(KnownFaults, DoNotHappenWhereTheyNeverDo) {
    constexpr std::uint64_t kBeforeZero = 0x61C8864680B583EB;
    EXPECT_EQ(FaultRandom(kBeforeZero).next(), 0U);
    EXPECT_FALSE(FaultRandom(kBeforeZero).happens(0));
}

TEST(KnownFaults, TakeNoNumberForADelayThatIsNone) {
    FaultRandom random(kSeed);
    EXPECT_EQ(random.delay(0ns), 0ns);
    EXPECT_EQ(random.next(), 6457827717110365317U);
}

TEST(KnownFaults, CutNothingOfAnEmptyBurst) {
    FaultInjector injector({.cut_frame = 1}, kSeed);
    Reception out;
    injector.apply(std::span<const std::uint8_t>(), out);
    EXPECT_EQ(out.count, 0U);
}

TEST(KnownFaults, LeaveOrTakeAwayABurstOfOneByte) {
    std::size_t left = 0;
    for (std::uint64_t seed = 0; seed < 100; ++seed) {
        FaultInjector injector({.cut_frame = 1}, seed);
        Reception out;
        injector.apply(Bytes{0x20}, out);
        left += out.count;
    }
    EXPECT_GT(left, 20U);
    EXPECT_LT(left, 80U);
}

TEST(LinkWithFaults, PassesSingleBytes) {
    MemoryLink inner;
    FaultyLink link(inner, {}, kSeed);
    inner.send(Bytes{0x20});
    Reception reception;
    EXPECT_EQ(link.read(reception), ReadStatus::received);
    EXPECT_EQ(reception.count, 1U);
    EXPECT_EQ(link.write(Bytes{0x40}), WriteStatus::written);
    EXPECT_EQ(inner.written().size(), 1U);
}

TEST(LinkWithFaults, LeavesNothingOfTheReadBefore) {
    MemoryLink inner;
    FaultyLink link(inner, {}, kSeed);
    Reception reception;
    reception.count = 9;
    reception.full = true;
    reception.damaged.set();
    EXPECT_EQ(link.read(reception), ReadStatus::nothing);
    EXPECT_EQ(reception.count, 0U);
    EXPECT_FALSE(reception.full || reception.damaged.any());
}

TEST(LinkWithFaults, SaysThatAFullReadMayLeaveMore) {
    MemoryLink inner;
    FaultyLink link(inner, {}, kSeed);
    inner.send(Bytes(kBytesPerRead));
    Reception reception;
    link.read(reception);
    EXPECT_TRUE(reception.full);
}

TEST(LinkWithFaults, DiscardsWhatWaitsAtTheOther) {
    MemoryLink inner;
    FaultyLink link(inner, {}, kSeed);
    inner.send(Bytes{1});
    link.discard_unread();
    Reception reception;
    EXPECT_EQ(inner.read(reception), ReadStatus::nothing);
    EXPECT_EQ(link.descriptor(), -1);
}

}  // namespace
}  // namespace tribus::test::known_faults_test
