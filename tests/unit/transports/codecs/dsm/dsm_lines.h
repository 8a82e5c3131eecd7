#pragma once

#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/streams.h"
#include "transports/codecs/dsm/dsm.h"

/// Frames of Spektrum DSM, and a line that carries them, for its tests.
namespace tribus::test::dsm_lines {

using namespace std::chrono_literals;

inline constexpr Instant kStart = Instant(1h);
inline constexpr std::uint16_t kUnused = 0xFFFF;

// ArduPilot, RCProtocolTest.cpp: a receiver's two phases of 11 bits (dsm2), one frame of 10 bits
// (dsm5), two phases of which the first has settings of a video transmitter now and then
// (dsmx22_vtx).
inline constexpr std::string_view kPhaseA = "00B280943C021BFE44004C005C00FFFF";
inline constexpr std::string_view kPhaseB = "00B20C032EAA1400215634025400FFFF";
inline constexpr std::string_view kTenBits = "03B205FE1755135509FC18AB00560DFD";
inline constexpr std::string_view kBeforeVtx = "00B20C002956140025F834005400FFFF";
inline constexpr std::string_view kOtherPhase = "00B281503C001BFD44004C005C00FFFF";
inline constexpr std::string_view kVtx = "00B20C002956140025F83400E000E00A";

inline Bytes frame_of(const std::vector<std::uint16_t>& words, std::uint8_t system = 0xB2) {
    Bytes bytes{0x00, system};
    for (std::size_t i = 0; i < 7; ++i) {
        const std::uint16_t word = i < words.size() ? words[i] : kUnused;
        bytes.push_back(static_cast<std::uint8_t>(word >> 8U));
        bytes.push_back(static_cast<std::uint8_t>(word));
    }
    return bytes;
}

inline std::uint16_t word_of(unsigned channel, unsigned value, unsigned bits = 11) {
    return static_cast<std::uint16_t>(channel << bits | value);
}

/// Seven channels with this value.
inline Bytes seven(unsigned value, unsigned bits = 11, std::uint8_t system = 0xB2) {
    std::vector<std::uint16_t> words;
    for (const unsigned channel : {1U, 5U, 2U, 3U, 0U, 4U, 6U}) {
        words.push_back(word_of(channel, value, bits));
    }
    return frame_of(words, system);
}

/// A line with a pause before each burst.
class PausedLine {
  public:
    explicit PausedLine(DsmScale scale = DsmScale::spektrum,
                        DsmResolution resolution = DsmResolution::either)
        : decoder_(scale, resolution) {}

    /// Returns the last frame that counts at once, if any.
    std::optional<ChannelFrame> hear(const Bytes& bytes, Duration after = 11ms,
                                     Split split = kOneRead) {
        now_ += after;
        std::vector<DecodedFrame> frames;
        pause();
        feed_into(frames, decoder_, bytes, split, now_);
        frames_ += frames.size();
        return frames.empty() ? std::nullopt : std::optional(frames.back().channels);
    }
    std::optional<ChannelFrame> hear(std::string_view hex, Duration after = 11ms) {
        return hear(from_hex(hex), after);
    }
    /// The pause behind what was heard. Returns the frame that it shows.
    std::optional<ChannelFrame> pause() {
        std::optional<ChannelFrame> shown;
        DecodedFrame frame;
        while (decoder_.silence(frame)) {
            shown = frame.channels;
            ++frames_;
        }
        return shown;
    }
    DsmDecoder& decoder() { return decoder_; }
    Instant now() const { return now_; }
    std::size_t frames() const { return frames_; }

  private:
    DsmDecoder decoder_;
    Instant now_ = kStart;
    std::size_t frames_ = 0;
};

inline double us(const std::optional<ChannelFrame>& frame, std::size_t channel) {
    return frame ? frame->channel_or(channel, Pulse{}).microseconds() : -1;
}

/// Rounded to the nearest eighth.
inline int exact_eighths(DsmScale scale, unsigned value, unsigned bits) {
    const double fine = bits == 10 ? 2.0 * value : value;
    const double exact = scale == DsmScale::spektrum ? (fine - 1024) / 1.7 + 1500 : fine / 2 + 988;
    return static_cast<int>(std::floor(exact * 8 + 0.5));
}

}  // namespace tribus::test::dsm_lines
