#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

/// The plain form of i-BUS2: each step written out, a bit at a time. Tests compare the decoder with
/// it. Sources: docs/protocols/ibus2.md.
namespace tribus::reference {

inline std::uint8_t plain_ibus2_check(std::span<const std::uint8_t> bytes) {
    std::uint8_t crc = 0xFF;
    for (const std::uint8_t byte : bytes) {
        for (int bit = 7; bit >= 0; --bit) {
            const bool out = ((crc >> 7) ^ (byte >> bit & 1)) != 0;
            crc = static_cast<std::uint8_t>((crc << 1) ^ (out ? 0x25 : 0));
        }
    }
    return crc;
}

inline std::vector<std::uint8_t> plain_ibus2_checked(std::vector<std::uint8_t> bytes) {
    bytes.push_back(plain_ibus2_check(bytes));
    return bytes;
}

/// Microseconds of a step, by the type of a channel.
inline const std::map<unsigned, double>& plain_ibus2_steps() {
    static const std::map<unsigned, double> steps{
        {0x02, 500}, {0x13, 250}, {0x14, 125},  {0x15, 50},   {0x16, 25},   {0x06, 20}, {0x07, 10},
        {0x18, 10},  {0x08, 4},   {0x19, 5},    {0x09, 2},    {0x1A, 2},    {0x0A, 1},  {0x1B, 1},
        {0x0B, 0.5}, {0x1C, 0.5}, {0x0C, 0.25}, {0x1D, 0.25}, {0x0D, 0.125}};
    return steps;
}

/// Numbers of so many bits each, the lowest bit first, in as few bytes as there must be.
inline std::vector<std::uint8_t> plain_ibus2_packed(
    const std::vector<std::pair<unsigned, unsigned>>& bits_and_numbers) {
    std::vector<bool> all;
    for (const auto& [bits, number] : bits_and_numbers) {
        for (unsigned bit = 0; bit < bits; ++bit) {
            all.push_back((number >> bit & 1U) != 0);
        }
    }
    std::vector<std::uint8_t> bytes((all.size() + 7) / 8);
    for (std::size_t bit = 0; bit < all.size(); ++bit) {
        bytes[bit / 8] =
            static_cast<std::uint8_t>(bytes[bit / 8] | (all[bit] ? 1U : 0U) << bit % 8);
    }
    return bytes;
}

/// A frame for all devices: subtype and flags in `first`.
inline std::vector<std::uint8_t> plain_ibus2_to_all(std::uint8_t first,
                                                    const std::vector<std::uint8_t>& packed,
                                                    std::uint8_t address = 0x07) {
    std::vector<std::uint8_t> bytes{first, static_cast<std::uint8_t>(packed.size() + 4), address};
    bytes.insert(bytes.end(), packed.begin(), packed.end());
    return plain_ibus2_checked(std::move(bytes));
}

/// The types of up to 32 channels; the others are not used.
inline std::vector<std::uint8_t> plain_ibus2_key(std::vector<unsigned> types) {
    types.resize(32);
    std::vector<std::pair<unsigned, unsigned>> fives;
    for (const unsigned type : types) {
        fives.emplace_back(5, type);
    }
    return plain_ibus2_to_all(0x04, plain_ibus2_packed(fives));
}

/// Channels with these types and values; negative ones as two's complement.
inline std::vector<std::uint8_t> plain_ibus2_channels(const std::vector<unsigned>& types,
                                                      const std::vector<int>& values,
                                                      std::uint8_t flags = 0) {
    std::vector<std::pair<unsigned, unsigned>> numbers;
    for (std::size_t i = 0; i < types.size(); ++i) {
        numbers.emplace_back(types[i] & 0x0FU, static_cast<unsigned>(values[i]));
    }
    return plain_ibus2_to_all(flags, plain_ibus2_packed(numbers));
}

struct PlainIbus2Frame {
    std::size_t at = 0;
    std::size_t length = 0;
    bool frame_lost = false;
    bool failsafe = false;
    std::array<std::optional<double>, 18> us{};
};

/// Reads whole streams.
class PlainIbus2 {
  public:
    /// All frames of channels.
    std::vector<PlainIbus2Frame> frames_of(std::span<const std::uint8_t> stream) {
        std::vector<PlainIbus2Frame> frames;
        for (std::size_t at = 0; at < stream.size();) {
            const std::size_t length = length_at(stream, at);
            if (length == 0) {
                ++at;
                continue;
            }
            if (auto frame = read(stream.subspan(at, length))) {
                frame->at = at;
                frames.push_back(*frame);
            }
            at += length;
        }
        return frames;
    }

  private:
    static std::size_t length_at(std::span<const std::uint8_t> stream, std::size_t at) {
        const std::uint8_t first = stream[at];
        std::size_t length = 0;
        if (first % 4 == 0 && first / 4 % 16 <= 2 && at + 1 < stream.size()) {
            length = stream[at + 1] >= 4 && stream[at + 1] <= 37 ? stream[at + 1] : 0U;
        } else if ((first % 4 == 1 || first % 4 == 2) && first / 4 <= 4) {
            length = 21;
        }
        const bool whole = length != 0 && at + length <= stream.size();
        return whole && plain_ibus2_check(stream.subspan(at, length - 1)) == stream[at + length - 1]
                   ? length
                   : 0;
    }
    std::optional<PlainIbus2Frame> read(std::span<const std::uint8_t> frame) {
        if (frame[0] % 4 != 0 || frame[2] % 8 != 7 || frame[2] >= 64) {
            return std::nullopt;
        }
        const auto packed = frame.subspan(3, frame.size() - 4);
        const auto number = [&](std::size_t first, unsigned bits) {
            unsigned value = 0;
            for (unsigned bit = 0; bit < bits; ++bit) {
                const std::size_t at = first + bit;
                value |= (packed[at / 8] >> at % 8 & 1U) << bit;
            }
            return value;
        };
        if (frame[0] / 4 % 16 == 1 && packed.size() >= 20) {
            types_.clear();
            for (std::size_t channel = 0; channel < 32; ++channel) {
                types_.push_back(number(5 * channel, 5));
            }
        }
        if (frame[0] / 4 % 16 != 0) {
            return std::nullopt;
        }
        PlainIbus2Frame result{.length = frame.size(),
                               .frame_lost = (frame[0] & 0x40) != 0,
                               .failsafe = (frame[0] & 0x80) != 0};
        std::size_t bits_of_all = 0;
        for (const unsigned type : types_) {
            bits_of_all += type & 0x0FU;
        }
        if (types_.empty() || packed.size() != (bits_of_all + 7) / 8) {
            return result;
        }
        std::size_t first = 0;
        for (std::size_t channel = 0; channel < result.us.size(); ++channel) {
            const unsigned bits = types_[channel] & 0x0FU;
            const auto step = plain_ibus2_steps().find(types_[channel]);
            if (step != plain_ibus2_steps().end()) {
                const unsigned raw = number(first, bits);
                const unsigned sign = 1U << (bits - 1);
                const int value = raw >= sign ? static_cast<int>(raw) - static_cast<int>(2 * sign)
                                              : static_cast<int>(raw);
                const bool keep = raw == sign;
                const bool stop = raw == sign + 1 && bits >= 6;
                if (!keep && !stop) {
                    result.us[channel] = std::clamp(1500 + value * step->second, 750.0, 2250.0);
                }
            }
            first += bits;
        }
        return result;
    }

    std::vector<unsigned> types_;
};

}  // namespace tribus::reference
