#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

/// The plain form of the CRSF codec: each step written out, a bit at a time. Tests compare the fast
/// codec with it. Sources: docs/protocols/crsf.md.
namespace tribus::reference {

/// A frame with a right check, where it begins in the stream.
struct PlainCrsfFrame {
    std::size_t at = 0;
    std::uint8_t type = 0;
    std::vector<std::uint8_t> payload;
};

inline std::uint8_t plain_crsf_check(std::span<const std::uint8_t> bytes) {
    std::uint8_t crc = 0;
    for (const std::uint8_t byte : bytes) {
        for (int bit = 7; bit >= 0; --bit) {
            const bool out = ((crc >> 7) ^ (byte >> bit & 1)) != 0;
            crc = static_cast<std::uint8_t>((crc << 1) ^ (out ? 0xD5 : 0));
        }
    }
    return crc;
}

/// Bits from bit `first` on, the lowest bit of a byte first.
inline unsigned plain_bits(std::span<const std::uint8_t> bytes, std::size_t first,
                           std::size_t count) {
    unsigned value = 0;
    for (std::size_t bit = 0; bit < count; ++bit) {
        const std::size_t at = first + bit;
        value |= (bytes[at / 8] >> at % 8 & 1U) << bit;
    }
    return value;
}

/// The frame that begins at `at`, if there is a whole one with a right check. Lengths that a type
/// cannot have are none.
inline std::optional<PlainCrsfFrame> plain_crsf_frame(std::span<const std::uint8_t> stream,
                                                      std::size_t at) {
    constexpr std::array<std::uint8_t, 5> kAddresses{0x00, 0xC8, 0xEA, 0xEC, 0xEE};
    if (at + 4 > stream.size() || std::ranges::count(kAddresses, stream[at]) == 0) {
        return std::nullopt;
    }
    const std::size_t length = stream[at + 1];
    const std::uint8_t type = stream[at + 2];
    const std::size_t least = type == 0x16   ? 24
                              : type == 0x14 ? 12
                              : type == 0x1C ? 7
                              : type == 0x17 ? 4
                                             : 2;
    if (length < least || length > 62 || at + 2 + length > stream.size()) {
        return std::nullopt;
    }
    const auto checked = stream.subspan(at + 2, length - 1);
    if (plain_crsf_check(checked) != stream[at + 1 + length]) {
        return std::nullopt;
    }
    return PlainCrsfFrame{at, type, {checked.begin() + 1, checked.end()}};
}

/// All frames of a whole stream. After a failed check the search goes on at the next byte.
inline std::vector<PlainCrsfFrame> plain_crsf_frames(std::span<const std::uint8_t> stream) {
    std::vector<PlainCrsfFrame> frames;
    for (std::size_t at = 0; at < stream.size();) {
        if (auto frame = plain_crsf_frame(stream, at)) {
            at += frame->payload.size() + 4;
            frames.push_back(std::move(*frame));
        } else {
            ++at;
        }
    }
    return frames;
}

/// Pulses in us of a frame of type 16.
inline std::vector<double> plain_crsf_channels(const PlainCrsfFrame& frame) {
    std::vector<double> channels;
    for (std::size_t channel = 0; channel < 16; ++channel) {
        const double raw = plain_bits(frame.payload, 11 * channel, 11);
        channels.push_back((raw - 992) * 5 / 8 + 1500);
    }
    return channels;
}

/// A frame with the check.
inline std::vector<std::uint8_t> plain_crsf(std::uint8_t address, std::uint8_t type,
                                            const std::vector<std::uint8_t>& payload) {
    std::vector<std::uint8_t> frame{address, static_cast<std::uint8_t>(payload.size() + 2), type};
    frame.insert(frame.end(), payload.begin(), payload.end());
    frame.push_back(plain_crsf_check(std::span(frame).subspan(2)));
    return frame;
}

/// The word of a module about its timing, in 0.1 us. Modules of ExpressLRS 4 begin with C8
/// (ExpressLRS commit 60013c7e7), others with EA.
inline std::vector<std::uint8_t> plain_crsf_timing(std::uint32_t period, std::int32_t offset,
                                                   std::uint8_t address = 0xEA) {
    std::vector<std::uint8_t> payload{0xEA, 0xEE, 0x10};
    for (const std::uint32_t number : {period, static_cast<std::uint32_t>(offset)}) {
        for (int shift = 24; shift >= 0; shift -= 8) {
            payload.push_back(static_cast<std::uint8_t>(number >> shift));
        }
    }
    return plain_crsf(address, 0x3A, payload);
}

/// The payload of 16 raw values.
inline std::vector<std::uint8_t> plain_crsf_packed(const std::array<std::uint16_t, 16>& raw) {
    std::vector<std::uint8_t> payload(22);
    for (std::size_t bit = 0; bit < 176; ++bit) {
        payload[bit / 8] = static_cast<std::uint8_t>(payload[bit / 8] |
                                                     (raw[bit / 11] >> bit % 11 & 1U) << bit % 8);
    }
    return payload;
}

}  // namespace tribus::reference
