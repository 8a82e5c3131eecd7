#include "transports/codecs/dsm/dsm.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/reference/betaflight_dsm.h"
#include "tests/support/streams.h"
#include "tests/unit/transports/codecs/dsm/dsm_lines.h"

/// How many frames of a line with faults tribus reads beside Betaflight's decoder.
namespace tribus::test::dsm_betaflight_test {
namespace {

using namespace dsm_lines;
using Values = reference::BetaflightDsmReader::Values;

enum class Hit : std::uint8_t { lost, added, cut, flipped };

/// Channels of both phases of a transmitter with 12 channels.
constexpr std::array<std::array<unsigned, 7>, 2> kPhases{
    {{1, 5, 2, 3, 0, 4, 6}, {1, 7, 2, 3, 0, 8, 9}}};

/// Sticks that move, each at its own pace; 700 steps each way.
unsigned stick(unsigned channel, std::size_t frame) {
    const double turns = static_cast<double>(frame) * (channel + 1) / 700;
    return static_cast<unsigned>(1024 + 700 * std::sin(6.283 * turns + channel));
}

Values sent_in(std::size_t frame) {
    Values values;
    for (const unsigned channel : kPhases[frame % 2]) {
        values[channel] = stick(channel, frame);
    }
    return values;
}

Bytes bytes_of(std::size_t frame) {
    std::vector<std::uint16_t> words;
    for (const unsigned channel : kPhases[frame % 2]) {
        const bool phase = words.empty() && frame % 2 == 1;
        words.push_back(static_cast<std::uint16_t>((phase ? 0x8000U : 0U) |
                                                   word_of(channel, stick(channel, frame))));
    }
    return frame_of(words);
}

Bytes hit_by(Hit hit, Bytes bytes, Random& random) {
    const auto at = bytes.begin() + random.below(16);
    switch (hit) {
        case Hit::lost:
            bytes.erase(at);
            break;
        case Hit::added: {
            // The byte first: compilers differ in which argument they compute first.
            const std::uint8_t byte = random.byte();
            bytes.insert(bytes.begin() + random.below(17), byte);
            break;
        }
        case Hit::cut:
            bytes.erase(at, bytes.end());
            break;
        case Hit::flipped:
            *at = static_cast<std::uint8_t>(*at ^ 1U << random.below(8));
            break;
    }
    return bytes;
}

/// How many frames were read with the values that were sent.
struct Read {
    std::size_t right = 0;
    std::size_t wrong = 0;

    void note(const Values& values, std::size_t frame) {
        ++(values == sent_in(frame) ? right : wrong);
    }
    void add(const Read& other) {
        right += other.right;
        wrong += other.wrong;
    }
};
struct Both {
    Read tribus;
    Read betaflight;
};

/// The values of the frame's own channels.
Values values_of(const ChannelFrame& channels, std::size_t frame) {
    Values values;
    for (const unsigned channel : kPhases[frame % 2]) {
        const auto pulse = channels.channel(channel);
        values[channel] = pulse ? static_cast<unsigned>((pulse->eighths() - 988 * 8) / 4) : 9999;
    }
    return values;
}

/// Reads 2,000 frames, one in ten of them hit.
Both read_with(Hit hit, std::uint32_t seed) {
    constexpr std::size_t kFrames = 2000;
    constexpr Duration kPeriod = 11ms;
    constexpr Duration kByteTime = 87us;
    Random random(seed);
    DsmDecoder decoder(DsmScale::betaflight);
    reference::BetaflightDsmReader betaflight;
    std::map<std::uint64_t, std::size_t> frame_at;
    std::uint64_t position = 0;
    Both both;
    const auto note = [&](const DecodedFrame& frame) {
        both.tribus.note(values_of(frame.channels, frame_at.at(frame.first_byte)),
                         frame_at.at(frame.first_byte));
    };
    for (std::size_t frame = 0; frame < kFrames; ++frame) {
        Bytes bytes = bytes_of(frame);
        if (random.below(10) == 0) {
            bytes = hit_by(hit, std::move(bytes), random);
        }
        DecodedFrame decoded;
        while (decoder.silence(decoded)) {
            note(decoded);
        }
        frame_at[position] = frame;
        position += bytes.size();
        Duration at = kPeriod * static_cast<int>(frame);
        for (const std::uint8_t byte : bytes) {
            at += kByteTime;
            if (const auto values = betaflight.take(byte, at)) {
                both.betaflight.note(*values, frame);
            }
        }
        std::span<const std::uint8_t> rest = bytes;
        while (decoder.next(rest, dsm_lines::kStart + at, decoded)) {
            note(decoded);
        }
    }
    return both;
}

struct Row {
    const char* name;
    Hit hit;
    std::size_t right_in_1000;   ///< at least, of what Betaflight reads right
    std::size_t wrong_in_40000;  ///< at most
};

class DsmBesideBetaflight : public testing::TestWithParam<Row> {};

// Nothing in a frame shows a flipped bit of a value, nor an added byte in the place of its last
// one: each frame that counts at once has this risk. So many were wrong before pauses were
// evidence.
INSTANTIATE_TEST_SUITE_P(Hits, DsmBesideBetaflight,
                         testing::Values(Row{"ByteLost", Hit::lost, 980, 0},
                                         Row{"ByteAdded", Hit::added, 980, 271},
                                         Row{"TailCut", Hit::cut, 980, 0},
                                         Row{"BitFlipped", Hit::flipped, 967, 2390}),
                         [](const auto& row) { return row.param.name; });

TEST_P(DsmBesideBetaflight, ReadsNearlyAllThatItReadsRight) {
    Both sum;
    for (std::uint32_t seed = 1; seed <= 20; ++seed) {
        const Both both = read_with(GetParam().hit, seed);
        sum.tribus.add(both.tribus);
        sum.betaflight.add(both.betaflight);
    }
    ASSERT_GT(sum.betaflight.right, 30'000U);
    EXPECT_GE(1000 * sum.tribus.right, GetParam().right_in_1000 * sum.betaflight.right);
    EXPECT_LE(sum.tribus.wrong, GetParam().wrong_in_40000);
}

}  // namespace
}  // namespace tribus::test::dsm_betaflight_test
