#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

/// The plain form of the GHST codec: each step written out, a bit at a time. Tests compare the fast
/// codec with it. Sources: docs/protocols/ghst.md.
namespace tribus::reference {

/// A frame with a right check, where it begins in the stream.
struct PlainGhstFrame {
    std::size_t at = 0;
    std::uint8_t type = 0;
    std::array<std::uint8_t, 10> payload{};

    /// 0x30 to 0x3F and 0x10 to 0x1F.
    bool is_new() const { return type / 16 == 3; }
    bool has_channels() const { return type / 16 == 3 || type / 16 == 1; }
};

inline std::uint8_t plain_ghst_check(std::span<const std::uint8_t> bytes) {
    bool crc[8] = {};
    for (const std::uint8_t byte : bytes) {
        for (int bit = 7; bit >= 0; --bit) {
            const bool out = crc[7] != ((byte >> bit & 1) != 0);
            for (int i = 7; i > 0; --i) {
                crc[i] = crc[i - 1];
            }
            crc[0] = false;
            // D5 is 1101 0101.
            for (const int tap : {0, 2, 4, 6, 7}) {
                crc[tap] = crc[tap] != out;
            }
        }
    }
    int value = 0;
    for (int i = 0; i < 8; ++i) {
        value += crc[i] ? 1 << i : 0;
    }
    return static_cast<std::uint8_t>(value);
}

/// A frame of this type with the check.
inline std::vector<std::uint8_t> plain_ghst(std::uint8_t type,
                                            const std::vector<std::uint8_t>& payload,
                                            std::uint8_t address = 0x82) {
    std::vector<std::uint8_t> frame{address, static_cast<std::uint8_t>(payload.size() + 2), type};
    frame.insert(frame.end(), payload.begin(), payload.end());
    frame.push_back(plain_ghst_check(std::span(frame).subspan(2)));
    return frame;
}

/// The payload of four raw values of 12 bits and four bytes.
inline std::vector<std::uint8_t> plain_ghst_payload(const std::array<unsigned, 4>& fine,
                                                    const std::array<unsigned, 4>& coarse) {
    std::vector<std::uint8_t> payload(6);
    for (std::size_t bit = 0; bit < 48; ++bit) {
        if ((fine[bit / 12] >> bit % 12 & 1U) != 0) {
            payload[bit / 8] = static_cast<std::uint8_t>(payload[bit / 8] + (1U << bit % 8));
        }
    }
    for (const unsigned byte : coarse) {
        payload.push_back(static_cast<std::uint8_t>(byte));
    }
    return payload;
}

/// All frames of a whole stream, of any type. After a failed check the search goes on at the next
/// byte.
inline std::vector<PlainGhstFrame> plain_ghst_frames(std::span<const std::uint8_t> stream) {
    std::vector<PlainGhstFrame> frames;
    for (std::size_t at = 0; at + 14 <= stream.size();) {
        const bool right = stream[at] == 0x82 && stream[at + 1] == 12 &&
                           plain_ghst_check(stream.subspan(at + 2, 11)) == stream[at + 13];
        if (!right) {
            ++at;
            continue;
        }
        PlainGhstFrame frame{.at = at, .type = stream[at + 2]};
        for (std::size_t i = 0; i < 10; ++i) {
            frame.payload[i] = stream[at + 3 + i];
        }
        frames.push_back(frame);
        at += 14;
    }
    return frames;
}

/// Raw value of channel 1 to 4, counted from 0.
inline unsigned plain_ghst_fine(const PlainGhstFrame& frame, std::size_t channel) {
    unsigned raw = 0;
    for (std::size_t bit = 0; bit < 12; ++bit) {
        const std::size_t at = 12 * channel + bit;
        raw += (frame.payload[at / 8] >> at % 8 & 1U) << bit;
    }
    return raw;
}

inline double plain_ghst_fine_us(bool is_new, unsigned raw) {
    return is_new ? 988 + raw / 4.0 : 988 + (std::floor(5.0 * raw / 4) - 430) / 4;
}
inline double plain_ghst_coarse_us(bool is_new, unsigned raw) {
    return is_new ? 988.0 + raw * 4.0 : 880.0 + raw * 5.0;
}

/// What is known of 16 channels after some frames. Times in ms.
class PlainGhstChannels {
  public:
    using Values = std::array<std::optional<double>, 16>;

    /// Returns the channels in us after this frame, which has channels.
    Values take(const PlainGhstFrame& frame, double now_ms) {
        for (std::size_t i = 0; i < 4; ++i) {
            values_[i] = plain_ghst_fine_us(frame.is_new(), plain_ghst_fine(frame, i));
        }
        const std::size_t group = frame.type % 16;
        if (group < 3) {
            for (std::size_t i = 0; i < 4; ++i) {
                values_[4 + 4 * group + i] =
                    plain_ghst_coarse_us(frame.is_new(), frame.payload[6 + i]);
            }
            at_ms_[group] = now_ms;
        }
        for (std::size_t channel = 4; channel < 16; ++channel) {
            if (now_ms - at_ms_[channel / 4 - 1] > 500) {
                values_[channel].reset();
            }
        }
        return values_;
    }

  private:
    Values values_{};
    std::array<double, 3> at_ms_{};
};

}  // namespace tribus::reference
