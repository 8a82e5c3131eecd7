#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "tests/reference/gap_readers.h"
#include "tests/support/sbus_streams.h"
#include "tests/support/streams.h"
#include "tests/support/timed_line.h"
#include "transports/codecs/sbus/sbus.h"

/// Number of good and of invented frames on a faulty line, compared with the decoders of flight
/// controllers on the same bytes.
namespace tribus::test::codec_sbus_bound_test {
namespace {

using namespace std::chrono_literals;

constexpr Duration kPeriod = 14ms;
constexpr std::uint32_t kFrames = 2000;

/// Sixteen sticks that move between -100 % and +100 % at different speeds, and tremble.
SbusPayload moving_sticks(std::uint32_t frame, Random& random) {
    constexpr double kCentre = 992;
    constexpr double kHalfWay = 790;
    SbusFrame sticks;
    for (std::size_t channel = 0; channel < kSbusChannels; ++channel) {
        const double phase = 0.01 * (1.0 + 0.3 * static_cast<double>(channel)) * frame;
        sticks.raw[channel] =
            static_cast<std::uint16_t>(kCentre + kHalfWay * std::sin(phase) + random.below(8));
    }
    std::array<std::uint8_t, kSbusFrameLength> wire{};
    emit_sbus(sticks, wire);
    SbusPayload payload{};
    std::copy_n(wire.begin() + 1, payload.size(), payload.begin());
    return payload;
}

SbusPayload random_sticks(std::uint32_t /*frame*/, Random& random) {
    return random_payload(random, false);
}

using Sticks = SbusPayload (*)(std::uint32_t, Random&);

/// Content of a frame as the decoder returns it. A frame is right if exactly this content was sent.
using Content = std::vector<std::uint16_t>;
Content content_of(const ChannelFrame& frame) {
    Content content;
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        content.push_back(static_cast<std::uint16_t>(frame.channel(channel)->eighths()));
    }
    content.push_back(frame.frame_lost ? 1 : 0);
    content.push_back(frame.failsafe ? 1 : 0);
    return content;
}
Content content_of(std::span<const std::uint8_t> wire) {
    SbusDecoder decoder;
    feed(decoder, wire);
    return content_of(decoder.finish()->channels);
}

struct World {
    TimedLine line;
    std::set<Content> sent;
    Random random;

    explicit World(std::uint32_t seed) : random(seed) {}
    Bytes frame(Sticks sticks, std::uint32_t index, std::uint8_t footer = 0) {
        const Bytes bytes = sbus_frame(sticks(index, random), 0, footer);
        sent.insert(content_of(bytes));
        return bytes;
    }
};

struct Score {
    std::size_t right = 0;
    std::size_t wrong = 0;

    void count(const World& world, const Content& content) {
        ++(world.sent.contains(content) ? right : wrong);
    }
};

Score ours(const World& world, const Port& port) {
    Score score;
    for (const ChannelFrame& frame : frames_of(std::make_unique<SbusDecoder>(), world.line, port)) {
        score.count(world, content_of(frame));
    }
    return score;
}

template <class Reader>
Score theirs(const World& world) {
    Score score;
    Reader reader;
    for (const WireByte& byte : world.line) {
        if (const auto* frame = reader.take(byte.value, byte.end)) {
            // These readers check neither flags nor footer.
            Bytes wire(frame->begin(), frame->end());
            wire[23] &= 0x0FU;
            wire[24] = 0;
            score.count(world, content_of(wire));
        }
    }
    return score;
}

enum class LineFault : std::uint8_t { byte_lost, byte_added, tail_cut, head_cut, noise };

/// Puts a frame with the fault on the wire. Returns when it ends.
Duration put_hit(World& world, Bytes frame, LineFault fault, Duration start) {
    const auto place = frame.begin() + static_cast<int>(world.random.below(kSbusFrameLength));
    const auto cut = 1 + world.random.below(kSbusFrameLength - 1);
    switch (fault) {
        case LineFault::byte_lost: {
            const Duration resumed = put(world.line, {frame.begin(), place}, start);
            return put(world.line, {place + 1, frame.end()}, resumed + kSbusByteTime);
        }
        case LineFault::byte_added:
            frame.insert(place, world.random.byte());
            return put(world.line, frame, start);
        case LineFault::tail_cut:
            frame.resize(frame.size() - cut);
            return put(world.line, frame, start);
        case LineFault::head_cut:
            frame.erase(frame.begin(), frame.begin() + static_cast<int>(cut));
            return put(world.line, frame, start + cut * kSbusByteTime);
        case LineFault::noise:
            break;
    }
    const Duration end = put(world.line, frame, start);
    Bytes noise(1 + world.random.below(8));
    std::ranges::generate(noise, [&] { return world.random.byte(); });
    const Duration room = start + kPeriod - end - (noise.size() + 1) * kSbusByteTime;
    const auto later = world.random.below(static_cast<std::uint32_t>(room / 1us));
    put(world.line, noise, end + std::chrono::microseconds(later));
    return end;
}

World with_faults(LineFault fault, std::uint32_t seed) {
    World world(seed);
    for (std::uint32_t i = 0; i < kFrames; ++i) {
        const Bytes frame = world.frame(moving_sticks, i);
        if (world.random.below(10) == 0) {
            put_hit(world, frame, fault, i * kPeriod);
        } else {
            put(world.line, frame, i * kPeriod);
        }
    }
    return world;
}

struct Bound {
    std::string_view name;
    LineFault fault;
    std::size_t most_wrong;
};
constexpr std::array kBounds{
    Bound{"byte lost", LineFault::byte_lost, 2}, Bound{"byte added", LineFault::byte_added, 5},
    Bound{"tail cut", LineFault::tail_cut, 2}, Bound{"head cut", LineFault::head_cut, 4},
    Bound{"noise in the gap", LineFault::noise, 0}};

void print(std::string_view fault, std::string_view who, const Score& score) {
    std::printf("[ BOUND    ] %-20.*s %-14.*s %5zu right %4zu wrong\n",
                static_cast<int>(fault.size()), fault.data(), static_cast<int>(who.size()),
                who.data(), score.right, score.wrong);
}

TEST(SbusBound, LetsAsManyFramesThatFaultsLeaveComeAsTheBestFlightController) {
    for (const Bound& bound : kBounds) {
        const World world = with_faults(bound.fault, 1);
        const Score betaflight = theirs<reference::BetaflightSbusReader>(world);
        const Score ardupilot = theirs<reference::ArduPilotSbusReader>(world);
        print(bound.name, "Betaflight", betaflight);
        print(bound.name, "ArduPilot", ardupilot);
        const std::size_t best = std::max(betaflight.right, ardupilot.right);
        for (const auto& [name, port] : prompt_ports()) {
            const Score score = ours(world, port);
            print(bound.name, name, score);
            EXPECT_GE(100 * score.right, 99 * best) << bound.name << ", " << name;
            EXPECT_LE(score.wrong, bound.most_wrong) << bound.name << ", " << name;
        }
    }
}

/// Checks that at least 99 % of the frames arrive and that no frame is invented.
void expect_nearly_all(const World& world, std::string_view what) {
    for (const auto& [name, port] : prompt_ports()) {
        const Score score = ours(world, port);
        print(what, name, score);
        EXPECT_GE(100 * score.right, 99 * world.sent.size()) << name;
        EXPECT_EQ(score.wrong, 0U) << name;
    }
}

TEST(SbusBound, AStrayByteBehindEachFrameCostsNone) {
    World world(2);
    for (std::uint32_t i = 0; i < 1000; ++i) {
        const Duration end = put(world.line, world.frame(moving_sticks, i), i * kPeriod);
        put(world.line, std::array{world.random.byte()}, end);
    }
    expect_nearly_all(world, "stray bytes");
}

// bolderflight/sbus, issue 79: Futaba R7003SB.
TEST(SbusBound, WhatAnR7003sbSendsBehindEachFrameCostsNone) {
    World world(3);
    for (std::uint32_t i = 0; i < 1000; ++i) {
        const Duration end = put(world.line, world.frame(moving_sticks, i), i * kPeriod);
        put(world.line, from_hex("00 03 c0 33 00"), end + 2ms);
    }
    expect_nearly_all(world, "R7003SB");
}

// docs/protocols/sbus.md, "Footer and SBUS2": slot 0 begins 2.03 ms after the frame, the others
// follow every 660 us.
TEST(SbusBound, SlotsWithAByteTooManyOrTooFewCostNone) {
    World world(4);
    for (std::uint32_t i = 0; i < 1000; ++i) {
        const auto footer = static_cast<std::uint8_t>(i % 4 << 4U | 0x04U);
        const Duration end = put(world.line, world.frame(moving_sticks, i, footer), i * 15ms);
        const std::uint32_t broken = world.random.below(16);
        for (std::uint32_t slot = 0; slot < 8; ++slot) {
            Bytes triple = slot_triple(i % 4 * 8 + slot, world.random.byte(), world.random.byte());
            if (slot == broken) {
                triple.resize(world.random.below(2) == 0 ? 2 : 4, world.random.byte());
            }
            put(world.line, triple, end + 2030us + slot * 660us);
        }
    }
    expect_nearly_all(world, "SBUS2 slots");
}

/// Returns six frames. Frame `hit` ends before byte `cut`.
World truncated(Sticks sticks, std::uint32_t hit, std::size_t cut, std::uint32_t seed) {
    World world(seed);
    const std::uint32_t first = world.random.below(100'000);
    for (std::uint32_t i = 0; i < 6; ++i) {
        Bytes frame = world.frame(sticks, first + i);
        if (i == hit) {
            frame.resize(cut);
        }
        put(world.line, frame, i * kPeriod);
    }
    return world;
}

TEST(SbusBound, NoTruncatedFrameBecomesOneThatNobodySent) {
    for (const Sticks sticks : {moving_sticks, random_sticks}) {
        Score score;
        std::size_t cuts = 0;
        for (std::uint32_t seed = 1; seed <= 280; ++seed) {
            for (std::uint32_t cut = 1; cut < kSbusFrameLength; ++cut) {
                const World world = truncated(sticks, seed % 3, cut, 100 * seed + cut);
                for (const auto& [name, port] : prompt_ports()) {
                    const Score one = ours(world, port);
                    score.right += one.right;
                    score.wrong += one.wrong;
                    ++cuts;
                }
            }
        }
        print(sticks == moving_sticks ? "truncated, moving" : "truncated, random",
              std::to_string(cuts) + " cuts", score);
        EXPECT_EQ(score.wrong, 0U);
        // 45 whole frames come, 5 at each of 3 ports with each of the first 3 frames cut. 43 count:
        // in bursts the first whole frame may begin one of 24 channels until the next read shows
        // the pause behind it. If that read brings a whole frame, both come out of it and count as
        // one. So it is where the first or the third frame is cut.
        EXPECT_GE(score.right, 43 * 5 * cuts / 45);
    }
}

// Adapters that hold bytes back split frames at pauses that the line does not have.
TEST(SbusBound, APortThatDeliversInLumpsLosesFewFrames) {
    for (const Duration step : {Duration(1ms), Duration(4ms), Duration(16ms)}) {
        World world(5);
        for (std::uint32_t i = 0; i < 1000; ++i) {
            put(world.line, world.frame(moving_sticks, i), i * kPeriod);
        }
        const Score score = ours(world, in_lumps_each(step));
        print("lumps", std::to_string(step / 1ms) + " ms", score);
        // Two frames in one read count as one here.
        EXPECT_GE(score.right, step < kPeriod ? 980U : 840U) << step / 1ms;
        EXPECT_EQ(score.wrong, 0U) << step / 1ms;
    }
}

}  // namespace
}  // namespace tribus::test::codec_sbus_bound_test
