#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

/// The plain form of the SRXL codec: each step written out, a bit at a time. Tests compare the fast
/// codec with it. Sources: docs/protocols/srxl.md.
namespace tribus::reference {

/// A frame with a right check, where it begins in the stream.
struct PlainSrxlFrame {
    std::size_t at = 0;
    std::vector<std::uint8_t> bytes;

    unsigned version() const { return bytes[0] - 0xA0U; }
    /// The word that begins with this byte.
    unsigned word(std::size_t byte) const { return bytes[byte] * 256U + bytes[byte + 1]; }
};

inline unsigned plain_srxl_check(std::span<const std::uint8_t> bytes) {
    bool crc[16] = {};
    for (const std::uint8_t byte : bytes) {
        for (int bit = 7; bit >= 0; --bit) {
            const bool out = crc[15] != ((byte >> bit & 1) != 0);
            for (int i = 15; i > 0; --i) {
                crc[i] = crc[i - 1];
            }
            crc[0] = out;
            crc[5] = crc[5] != out;
            crc[12] = crc[12] != out;
        }
    }
    unsigned value = 0;
    for (int i = 0; i < 16; ++i) {
        value += crc[i] ? 1U << i : 0U;
    }
    return value;
}

inline std::vector<std::uint8_t> plain_srxl_checked(std::vector<std::uint8_t> bytes) {
    const unsigned crc = plain_srxl_check(bytes);
    bytes.push_back(static_cast<std::uint8_t>(crc / 256));
    bytes.push_back(static_cast<std::uint8_t>(crc % 256));
    return bytes;
}

/// A frame of version 1 (12 words), 2 (16 words) or 5 (7 words).
inline std::vector<std::uint8_t> plain_srxl(unsigned version, const std::vector<unsigned>& words,
                                            std::uint8_t flags = 0x02) {
    std::vector<std::uint8_t> bytes{static_cast<std::uint8_t>(0xA0 + version)};
    if (version == 5) {
        bytes.push_back(flags);
    }
    for (const unsigned word : words) {
        bytes.push_back(static_cast<std::uint8_t>(word / 256));
        bytes.push_back(static_cast<std::uint8_t>(word % 256));
    }
    return plain_srxl_checked(bytes);
}

inline std::size_t plain_srxl_length(std::uint8_t first) {
    return first == 0xA1 ? 27 : first == 0xA2 ? 35 : first == 0xA5 ? 18 : 0;
}

/// All frames of a whole stream. After a failed check the search goes on at the next byte.
inline std::vector<PlainSrxlFrame> plain_srxl_frames(std::span<const std::uint8_t> stream) {
    std::vector<PlainSrxlFrame> frames;
    for (std::size_t at = 0; at < stream.size();) {
        const std::size_t length = plain_srxl_length(stream[at]);
        const bool whole = length != 0 && at + length <= stream.size();
        if (whole && plain_srxl_check(stream.subspan(at, length)) == 0) {
            const auto bytes = stream.subspan(at, length);
            frames.push_back({at, {bytes.begin(), bytes.end()}});
            at += length;
        } else {
            ++at;
        }
    }
    return frames;
}

/// The nearest eighth, halves upwards.
inline double plain_nearest_eighth(double us) {
    return std::floor(us * 8 + 0.5) / 8;
}
inline double plain_srxl_us(unsigned raw) {
    return plain_nearest_eighth(800 + (raw % 4096) * 1400.0 / 4096);
}
inline double plain_srxl_word_us(unsigned word) {
    return plain_nearest_eighth((static_cast<double>(word % 2048) - 1024) * 500 / 876 + 1500);
}

/// What is known of the channels after some frames. Times in ms.
class PlainSrxlChannels {
  public:
    using Values = std::array<std::optional<double>, 16>;

    Values take(const PlainSrxlFrame& frame, double now_ms) {
        Values values;
        if (frame.version() != 5) {
            for (std::size_t i = 0; i < (frame.version() == 1 ? 12U : 16U); ++i) {
                values[i] = plain_srxl_us(frame.word(1 + 2 * i));
            }
            return values;
        }
        for (std::size_t i = 0; i < 7; ++i) {
            const unsigned word = frame.word(2 + 2 * i);
            if (word / 2048 < 12) {
                words_[word / 2048] = {plain_srxl_word_us(word), now_ms};
            }
        }
        for (std::size_t i = 0; i < words_.size(); ++i) {
            if (words_[i] && now_ms - words_[i]->at_ms <= 200) {
                values[i] = words_[i]->us;
            }
        }
        return values;
    }

  private:
    struct Word {
        double us = 0;
        double at_ms = 0;
    };
    std::array<std::optional<Word>, 12> words_{};
};

}  // namespace tribus::reference
