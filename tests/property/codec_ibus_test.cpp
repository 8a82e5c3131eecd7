#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/ibus_frames.h"
#include "tests/support/streams.h"
#include "transports/codecs/ibus/ibus.h"

namespace tribus::codec_ibus_test {
namespace {

using test::append;
using test::Bytes;
using test::Fault;
using test::FaultKind;
using test::feed;
using test::feed_into;
using test::FrameStream;
using test::from_hex;
using test::Random;
using test::same_frames;

constexpr std::size_t kFrameLength = 32;
constexpr std::size_t kHitFrame = 1;
constexpr std::uint32_t kFrames = 4;

Bytes servo_frame(const Bytes& payload) {
    return test::servo_frame(payload, 0x40);
}

struct Sticks {
    std::string name;
    std::vector<Bytes> payloads;  ///< one for each frame
};

/// Payloads of 28 bytes: full of headers, of both variants and of shorter frames, then random
/// bytes, still and moving.
std::vector<Sticks> all_sticks() {
    std::vector<Sticks> all;
    for (const std::string_view pattern :
         {"20 40", "20 40 55", "55", "55 00", "00 55", "06 40", "00 06 40 00", "00", "ff", "dc 55",
          "55 00 20 40", "04 81 7a ff", "00 0f 07"}) {
        const Bytes bytes = from_hex(pattern);
        Bytes payload;
        while (payload.size() < 28) {
            payload.push_back(bytes[payload.size() % bytes.size()]);
        }
        all.push_back({std::string(pattern), std::vector<Bytes>(kFrames, payload)});
    }
    constexpr std::array<std::uint8_t, 8> kHard{0x20, 0x40, 0x55, 0x00, 0x06, 0x0F, 0x05, 0xDC};
    for (std::uint32_t seed = 1; seed <= 2; ++seed) {
        for (const bool hard : {false, true}) {
            Random random(seed);
            Sticks moving{(hard ? "hard " : "any ") + std::to_string(seed), {}};
            for (std::uint32_t frame = 0; frame < kFrames; ++frame) {
                Bytes payload(28);
                for (std::uint8_t& byte : payload) {
                    byte = hard ? kHard[random.below(kHard.size())] : random.byte();
                }
                moving.payloads.push_back(payload);
            }
            all.push_back(
                {moving.name + ", still", std::vector<Bytes>(kFrames, moving.payloads.front())});
            all.push_back(moving);
        }
    }
    return all;
}

FrameStream stream_of(const Sticks& sticks) {
    FrameStream stream;
    for (const Bytes& payload : sticks.payloads) {
        stream.add_frame(servo_frame(payload));
    }
    return stream;
}

class IbusResync {
  public:
    explicit IbusResync(const Sticks& sticks) : name_(sticks.name), stream_(stream_of(sticks)) {
        IbusDecoder decoder;
        clean_ = feed(decoder, stream_.bytes);
    }

    bool decodes_without_a_fault() const { return clean_.size() == stream_.starts.size(); }

    /// Checks that at most the hit frame is missing and that no other frame appears.
    void hit(const Fault& fault, test::Split split) const {
        IbusDecoder decoder;
        const auto decoded = feed(decoder, stream_.bytes, fault, split);
        const test::Damage damage = compare(stream_, fault, clean_, decoded);
        const bool only_hit_frame =
            damage.missing.empty() || damage.missing == std::vector{kHitFrame};
        if (!only_hit_frame || damage.invented != 0) {
            ADD_FAILURE() << name_ << ", " << fault << ": " << damage.missing.size()
                          << " frames missing, " << damage.invented << " invented";
        }
    }

    std::size_t place(std::size_t offset) const { return stream_.starts[kHitFrame] + offset; }
    std::uint8_t at(std::size_t position) const { return stream_.bytes[position]; }

  private:
    std::string name_;
    FrameStream stream_;
    std::vector<DecodedFrame> clean_;
};

TEST(IbusResyncProperty, OneLostOrDamagedByteCostsTheFrameItHits) {
    for (const Sticks& sticks : all_sticks()) {
        const IbusResync resync(sticks);
        ASSERT_TRUE(resync.decodes_without_a_fault()) << sticks.name;
        for (std::size_t offset = 0; offset < kFrameLength; ++offset) {
            for (const FaultKind kind : {FaultKind::lost, FaultKind::damaged}) {
                for (const test::Split split :
                     {test::kOneRead, test::kByteByByte, test::Split{40, 7}}) {
                    resync.hit({kind, resync.place(offset), 0}, split);
                }
            }
        }
    }
}

TEST(IbusResyncProperty, OneAddedByteOfAnyValueCostsTheFrameItHits) {
    for (const Sticks& sticks : all_sticks()) {
        const IbusResync resync(sticks);
        for (std::size_t offset = 0; offset < kFrameLength; ++offset) {
            for (unsigned value = 0; value < 256; ++value) {
                // A copy of the first byte gives the same stream before and after it, so it is put
                // before it.
                std::size_t position = resync.place(offset);
                if (offset == 1 && value == resync.at(position - 1)) {
                    --position;
                }
                resync.hit({FaultKind::added, position, static_cast<std::uint8_t>(value)},
                           test::kOneRead);
            }
        }
    }
}

TEST(IbusResyncProperty, OneByteReplacedByAnyOtherCostsTheFrameItHits) {
    for (const Sticks& sticks : all_sticks()) {
        const IbusResync resync(sticks);
        for (std::size_t offset = 0; offset < kFrameLength; ++offset) {
            const std::size_t position = resync.place(offset);
            for (unsigned value = 0; value < 256; ++value) {
                if (value != resync.at(position)) {
                    resync.hit({FaultKind::replaced, position, static_cast<std::uint8_t>(value)},
                               test::kOneRead);
                }
            }
        }
    }
}

// A false start inside a bad frame does not hold the next frame back.
TEST(IbusResyncProperty, TheFrameBehindABadOneComesWithItsLastByte) {
    for (const Sticks& sticks : all_sticks()) {
        const FrameStream stream = stream_of(sticks);
        const auto all = std::span<const std::uint8_t>(stream.bytes);
        for (std::size_t offset = 0; offset < kFrameLength; ++offset) {
            IbusDecoder decoder;
            std::vector<DecodedFrame> frames;
            feed_into(frames, decoder, all.first(kFrameLength + offset));
            decoder.damaged_byte();
            feed_into(frames, decoder,
                      all.subspan(kFrameLength + offset + 1, 2 * kFrameLength - offset - 1));
            ASSERT_EQ(frames.size(), 2U) << sticks.name << ", offset " << offset;
            ASSERT_EQ(frames.back().first_byte, 2 * kFrameLength);
        }
    }
}

/// Tells which frames count: those with the length of the ones before, or the third in a row with
/// another length.
class UsualLength {
  public:
    bool counts(std::size_t length) {
        in_a_row_ = length == latest_ ? in_a_row_ + 1 : 1;
        latest_ = length;
        if (usual_ == 0 || in_a_row_ == 3) {
            usual_ = length;
        }
        return length == usual_;
    }

  private:
    std::size_t usual_ = 0;
    std::size_t latest_ = 0;
    int in_a_row_ = 0;
};

/// Returns where frames are, found by one scan of the whole stream that follows
/// docs/protocols/ibus.md, "Servo frame", "Synchronisation" and "Variants", without i-BUS2.
std::vector<std::size_t> places_of_frames(const Bytes& bytes) {
    std::vector<std::size_t> places;
    UsualLength usual;
    for (std::size_t at = 0; at + 6 <= bytes.size();) {
        const auto rest = std::span(bytes).subspan(at);
        std::size_t length = 0;
        if (rest[0] == 0x55) {
            length = 31;
        } else if (rest[0] >= 6 && rest[0] <= 32 && rest[0] % 2 == 0 &&
                   (rest[1] == 0x40 || (rest[0] == 32 && rest[1] == 0))) {
            length = rest[0];
        }
        if (length > rest.size()) {
            break;
        }
        bool good = length != 0;
        if (good) {
            const unsigned found = rest[length - 2] | unsigned{rest[length - 1]} << 8U;
            unsigned sum = 0;
            for (std::size_t word = 1; length == 31 && word < 29; word += 2) {
                sum += rest[word] | unsigned{rest[word + 1]} << 8U;
                good = good && rest[word + 1] < 0x10;
            }
            good = good && found == (length == 31 ? sum & 0xFFFFU
                                                  : test::ibus_checksum(rest.first(length - 2)));
        }
        if (good && usual.counts(length)) {
            places.push_back(at);
        }
        at += good ? length : 1;
    }
    return places;
}

/// Returns good frames of every kind among bytes that often look like a start.
Bytes mixed_stream(Random& random) {
    constexpr std::array<std::uint8_t, 10> kLikely{0x20, 0x40, 0x55, 0x06, 0x08,
                                                   0x00, 0x10, 0x1E, 0x04, 0x81};
    Bytes bytes = servo_frame(from_hex("dc 05 dc 05"));  // no i-BUS2 after this
    while (bytes.size() < 2000) {
        switch (random.below(4)) {
            case 0: {
                Bytes payload(2 * (1 + random.below(14)));
                for (std::uint8_t& byte : payload) {
                    byte = random.byte();
                }
                append(bytes, servo_frame(payload));
                break;
            }
            case 1:
                append(bytes, from_hex("55 00 00 01 00 02 00 03 00 04 00 05 00 06 00 07 00 08 00 "
                                       "09 00 0a 00 0b 00 0c 00 0d 00 5b 00"));
                break;
            default:
                for (std::uint32_t count = random.below(12); count > 0; --count) {
                    bytes.push_back(random.below(2) == 0 ? random.byte()
                                                         : kLikely[random.below(kLikely.size())]);
                }
        }
    }
    return bytes;
}

TEST(IbusStreamProperty, FindsExactlyTheFramesThatAScanOfTheWholeStreamFinds) {
    for (std::uint32_t seed = 1; seed <= 200; ++seed) {
        Random random(seed);
        const Bytes bytes = mixed_stream(random);
        IbusDecoder decoder;
        std::vector<std::size_t> found;
        for (const DecodedFrame& frame : feed(decoder, bytes, {.longest = 90, .seed = seed})) {
            found.push_back(static_cast<std::size_t>(frame.first_byte));
        }
        ASSERT_EQ(found, places_of_frames(bytes)) << "seed " << seed;
    }
}

TEST(IbusStreamProperty, DoesNotDependOnHowTheStreamIsCut) {
    for (std::uint32_t seed = 1; seed <= 60; ++seed) {
        Random random(seed);
        const Bytes bytes = mixed_stream(random);
        IbusDecoder whole;
        const auto expected = feed(whole, bytes);
        for (const test::Split split : {test::kByteByByte, test::Split{3, seed},
                                        test::Split{100, seed}, test::Split{31}, test::Split{33}}) {
            IbusDecoder decoder;
            ASSERT_TRUE(same_frames(feed(decoder, bytes, split), expected)) << "seed " << seed;
            ASSERT_EQ(decoder.skipped_bytes(), whole.skipped_bytes());
            ASSERT_EQ(test::count_of(decoder, "checksum"), test::count_of(whole, "checksum"));
        }
    }
}

TEST(IbusStreamProperty, EveryByteIsInAFrameOrSkipped) {
    for (std::uint32_t seed = 1; seed <= 100; ++seed) {
        Random random(seed);
        Bytes bytes = mixed_stream(random);
        bytes.insert(bytes.end(), 40, 0xFF);  // ends whatever the decoder waits for
        IbusDecoder decoder;
        std::uint64_t in_frames = 0;
        for (const DecodedFrame& frame : feed(decoder, bytes)) {
            in_frames += frame.length;
        }
        ASSERT_GT(in_frames, 0U);
        ASSERT_EQ(in_frames + decoder.skipped_bytes(), bytes.size()) << "seed " << seed;
    }
}

// By chance one place in 300 million is a frame: 14 lengths, a command, 16 bits of checksum.
TEST(IbusStreamProperty, RandomBytesAreNoFrames) {
    Random random(2024);
    Bytes bytes(1'000'000);
    for (std::uint8_t& byte : bytes) {
        byte = random.byte();
    }
    IbusDecoder decoder;
    EXPECT_TRUE(feed(decoder, bytes).empty());
    EXPECT_GT(test::count_of(decoder, "checksum"), 100U);
}

TEST(IbusStreamProperty, DamagedBytesAnywhereNeverOverrunOrFeignAFrame) {
    for (std::uint32_t seed = 1; seed <= 100; ++seed) {
        Random random(seed);
        const Bytes bytes = mixed_stream(random);
        SCOPED_TRACE(seed);
        IbusDecoder decoder;
        test::expect_no_frame_over_damage(decoder, bytes, random, 80);
    }
}

ChannelFrame any_frame() {
    ChannelFrame frame;
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        if (*rc::gen::inRange(0, 4) != 0) {
            frame.set(channel, Pulse::from_eighths(*rc::gen::inRange(-32768, 32768)));
        }
    }
    frame.frame_lost = *rc::gen::arbitrary<bool>();
    frame.failsafe = *rc::gen::arbitrary<bool>();
    return frame;
}

RC_GTEST_PROP(IbusEncoderProperty, EveryFrameHasAnEncodingThatDecodesToItsWholeMicroseconds, ()) {
    const ChannelFrame frame = any_frame();
    for (const std::size_t channels : {std::size_t{14}, std::size_t{18}}) {
        std::array<std::uint8_t, kLongestSerialFrame> wire{};
        const std::size_t length = IbusEncoder(channels).write(frame, wire, Instant{});
        IbusDecoder decoder;
        const auto frames = feed(decoder, std::span(wire).first(length));
        RC_ASSERT(frames.size() == 1U);
        for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
            const int sent =
                std::clamp(frame.channel_or(channel, kCentrePulse).whole_microseconds(), 0, 4095);
            const bool present =
                channel < 14 || (channel < channels && frame.has(channel) && sent != 0);
            RC_ASSERT(frames[0].channels.has(channel) == present);
            RC_ASSERT(!present ||
                      frames[0].channels.channel(channel) == Pulse::from_microseconds(sent));
        }
    }
}

}  // namespace
}  // namespace tribus::codec_ibus_test
