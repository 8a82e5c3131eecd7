#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

/// The plain form of the EX Bus decoder: each step written out, a bit at a time. Tests compare the
/// fast decoder with it. Sources: docs/protocols/exbus.md.
namespace tribus::reference {

/// A frame with a right check, where it begins in the stream.
struct PlainExBusFrame {
    std::size_t at = 0;
    std::size_t length = 0;
    bool has_channels = false;
    /// Pulses in us; 0 for a channel that is not there.
    std::vector<double> channels;
};

/// Each bit of a byte, the lowest first, meets the lowest bit of the remainder.
inline unsigned plain_exbus_check(std::span<const std::uint8_t> bytes) {
    unsigned remainder = 0;
    for (const unsigned byte : bytes) {
        for (unsigned bit = 0; bit < 8; ++bit) {
            const unsigned out = (remainder ^ (byte >> bit)) & 1U;
            remainder = remainder / 2;
            if (out == 1) {
                remainder ^= 0x8408;
            }
        }
    }
    return remainder;
}

/// The frame that begins at `at`, if there is a whole one with a right check.
inline std::optional<PlainExBusFrame> plain_exbus_frame(std::span<const std::uint8_t> stream,
                                                        std::size_t at) {
    const auto rest = stream.subspan(at);
    if (rest.size() < 8) {
        return std::nullopt;
    }
    const unsigned first = rest[0];
    const unsigned length = rest[2];
    const unsigned data = rest[5];
    const bool channels = first == 0x3E && rest[4] == 0x31;
    if ((first != 0x3E && first != 0x3D && first != 0x3B) || (rest[1] != 1 && rest[1] != 3) ||
        length != data + 8 || length > 64 || length > rest.size()) {
        return std::nullopt;
    }
    if (channels && (data == 0 || data % 2 == 1 || data / 2 > 24)) {
        return std::nullopt;
    }
    if (plain_exbus_check(rest.first(length - 2)) != rest[length - 2] + 256U * rest[length - 1]) {
        return std::nullopt;
    }
    PlainExBusFrame frame{at, length, channels, {}};
    for (unsigned channel = 0; channels && channel < data / 2 && channel < 18; ++channel) {
        const unsigned word = rest[6 + 2 * channel] + 256U * rest[7 + 2 * channel];
        frame.channels.push_back(word >= 4096 * 8 ? 0 : word / 8.0);
    }
    return frame;
}

/// All frames of a whole stream. After a failed check the search goes on at the next byte.
inline std::vector<PlainExBusFrame> plain_exbus_frames(std::span<const std::uint8_t> stream) {
    std::vector<PlainExBusFrame> frames;
    for (std::size_t at = 0; at < stream.size();) {
        if (auto frame = plain_exbus_frame(stream, at)) {
            at += frame->length;
            frames.push_back(*frame);
        } else {
            ++at;
        }
    }
    return frames;
}

/// A frame with the check.
inline std::vector<std::uint8_t> plain_exbus(std::uint8_t first, std::uint8_t access,
                                             std::uint8_t kind,
                                             const std::vector<std::uint8_t>& data) {
    std::vector<std::uint8_t> frame{first, access, static_cast<std::uint8_t>(data.size() + 8),
                                    0x06,  kind,   static_cast<std::uint8_t>(data.size())};
    frame.insert(frame.end(), data.begin(), data.end());
    const unsigned check = plain_exbus_check(frame);
    frame.push_back(static_cast<std::uint8_t>(check % 256));
    frame.push_back(static_cast<std::uint8_t>(check / 256));
    return frame;
}

/// A frame of channels.
inline std::vector<std::uint8_t> plain_exbus_channels(const std::vector<std::uint16_t>& words) {
    std::vector<std::uint8_t> data;
    for (const std::uint16_t word : words) {
        data.push_back(static_cast<std::uint8_t>(word % 256));
        data.push_back(static_cast<std::uint8_t>(word / 256));
    }
    return plain_exbus(0x3E, 0x03, 0x31, data);
}

}  // namespace tribus::reference
