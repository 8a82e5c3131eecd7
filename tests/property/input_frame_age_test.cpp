#include <gtest/gtest.h>

#include <bitset>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "pipelines/engine/input.h"
#include "tests/support/ibus_frames.h"
#include "tests/support/sbus_streams.h"
#include "tests/support/streams.h"
#include "transports/codecs/ibus/ibus.h"
#include "transports/codecs/sbus/sbus.h"

/// An input knows when the last byte of a frame was read, no matter how long the decoder holds the
/// frame back and what makes it return the frame.
namespace tribus::test::input_frame_age_test {
namespace {

constexpr std::size_t kMostRead = 64;

Bytes sbus_bytes(Random& random) {
    constexpr std::array<std::uint8_t, 4> kFooters{0x00, 0x00, 0x04, 0x08};
    const std::uint8_t footer = kFooters[random.below(kFooters.size())];
    Bytes bytes = sbus_frame(random_payload(random, random.below(2) == 0), 0, footer);
    for (std::uint32_t slot = footer == 0 ? 0 : random.below(9); slot > 0; --slot) {
        append(bytes, slot_triple(random.below(32), 0x0F, random.byte()));
    }
    return bytes;
}

/// Returns a frame of 1 to 14 channels, so that one may end while the decoder waits for another.
Bytes ibus_bytes(Random& random) {
    Bytes slots(2 * (1 + random.below(14)));
    for (std::size_t at = 0; at < slots.size(); ++at) {
        // Sometimes bytes that look like the header of a long frame.
        const auto header = static_cast<std::uint8_t>(at % 2 == 0 ? 0x20 : 0x40);
        slots[at] = random.below(4) == 0 ? header : random.byte();
    }
    return servo_frame(slots, 0x40);
}

/// An input, and a second decoder of the same kind that tells where the frames are.
class Beside {
  public:
    template <class Kind>
    static Beside of() {
        return {std::make_unique<Kind>(), std::make_unique<Kind>()};
    }

    void read(const Bytes& bytes, const std::bitset<kMostRead>& damaged, Instant now) {
        read_at_.insert(read_at_.end(), bytes.size(), now);
        input_.receive(bytes, damaged, now);
        std::optional<DecodedFrame> latest;
        std::size_t start = 0;
        for (std::size_t at = 0; at <= bytes.size(); ++at) {
            if (at == bytes.size() || damaged[at]) {
                auto run = std::span(bytes).subspan(start, at - start);
                for (DecodedFrame frame; decoder_->next(run, now, frame);) {
                    latest = frame;
                }
                start = at + 1;
            }
            if (at < bytes.size() && damaged[at]) {
                decoder_->damaged_byte();
            }
        }
        if (latest) {
            const auto last = static_cast<std::size_t>(latest->first_byte + latest->length - 1);
            const Instant arrival = read_at_[last];
            ASSERT_EQ(input_.latest().received, arrival) << "at byte " << latest->first_byte;
            held_ += arrival < now ? 1U : 0U;
        }
    }
    /// Number of frames that the decoder returned later than with their last byte.
    std::size_t held() const { return held_; }

  private:
    Beside(std::unique_ptr<ByteDecoder> inner, std::unique_ptr<ByteDecoder> beside)
        : input_({.name = "in", .decoder = std::move(inner)}, 0), decoder_(std::move(beside)) {}

    Input input_;
    std::unique_ptr<ByteDecoder> decoder_;
    std::vector<Instant> read_at_;
    std::size_t held_ = 0;
};

/// Sends frames with lost, changed and damaged bytes in reads of any length. Returns the number of
/// held frames.
std::size_t frames_held(Beside beside, Bytes (*frame)(Random&), std::uint32_t seed) {
    Random random(seed);
    Instant now{};
    Bytes line;
    const std::uint32_t rarity = 10 + random.below(150);
    const std::uint32_t longest = 1 + random.below(kMostRead);
    for (int frames = 0; frames < 60; ++frames) {
        append(line, frame(random));
        while (line.size() >= kMostRead) {
            Bytes read(line.begin(), line.begin() + 1 + static_cast<int>(random.below(longest)));
            line.erase(line.begin(), line.begin() + static_cast<std::ptrdiff_t>(read.size()));
            std::bitset<kMostRead> damaged;
            for (std::size_t at = 0; at < read.size(); ++at) {
                damaged[at] = random.below(2 * rarity) == 0;
                if (random.below(2 * rarity) == 0) {
                    read[at] ^= static_cast<std::uint8_t>(1U << random.below(8));
                }
            }
            if (random.below(rarity) == 0) {
                read.pop_back();
            }
            now += std::chrono::microseconds(random.below(20'000));
            beside.read(read, damaged, now);
        }
    }
    return beside.held();
}

TEST(FrameAge, IsThatOfTheLastByteWithSbusWhateverTheLineDoes) {
    std::size_t held = 0;
    for (std::uint32_t seed = 1; seed <= 2000 && !HasFatalFailure(); ++seed) {
        held += frames_held(Beside::of<SbusDecoder>(), sbus_bytes, seed);
    }
    EXPECT_GT(held, 100U) << "too few frames were held to show anything";
}

TEST(FrameAge, IsThatOfTheLastByteWithIbusWhateverTheLineDoes) {
    std::size_t held = 0;
    for (std::uint32_t seed = 1; seed <= 2000 && !HasFatalFailure(); ++seed) {
        held += frames_held(Beside::of<IbusDecoder>(), ibus_bytes, seed);
    }
    EXPECT_GT(held, 300U) << "too few frames were held to show anything";
}

}  // namespace
}  // namespace tribus::test::input_frame_age_test
