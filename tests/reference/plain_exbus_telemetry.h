#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "tests/reference/plain_exbus.h"

/// The plain reader of telemetry that an EX Bus sensor answers with. Source:
/// docs/protocols/exbus.md, "Telemetry".
namespace tribus::reference {

struct PlainExBusAnswer {
    unsigned packet = 0;
    unsigned device = 0;
    /// Number of what has this name: 0 the device, else a sensor. Nothing: the answer has numbers.
    std::optional<unsigned> named;
    std::string label;
    std::string unit;
    std::map<unsigned, double> numbers;
};

/// Each bit of a byte, the highest first, polynomial x^8 + x^2 + x + 1.
inline unsigned plain_ex_check(std::span<const std::uint8_t> bytes) {
    unsigned remainder = 0;
    for (const unsigned byte : bytes) {
        for (int bit = 7; bit >= 0; --bit) {
            const bool out = (remainder >= 128) != ((byte >> bit) % 2 == 1);
            remainder = remainder * 2 % 256;
            if (out) {
                remainder ^= 0x07;
            }
        }
    }
    return remainder;
}

/// A number of `bytes` bytes, the low one first: the highest bit says negative, two bits count
/// decimals, the others are the number in two's complement.
inline double plain_ex_decimal(std::span<const std::uint8_t> bytes) {
    double number = 0;
    double place = 1;
    for (std::size_t at = 0; at < bytes.size(); ++at) {
        const unsigned part = at + 1 == bytes.size() ? bytes[at] % 32 : bytes[at];
        number += part * place;
        place *= at + 1 == bytes.size() ? 32 : 256;
    }
    if (bytes.back() >= 128) {
        number -= place;
    }
    return number / std::pow(10, bytes.back() / 32 % 4);
}

/// Degrees: thousandths of a minute, then whole degrees with 40 for south and west.
inline double plain_ex_position(std::span<const std::uint8_t> bytes) {
    const double minutes = (bytes[0] + 256 * bytes[1]) / 1000.0;
    const unsigned whole = bytes[2] + 256U * (bytes[3] % 2);
    const double degrees = whole + minutes / 60;
    return bytes[3] / 64 % 2 == 1 ? -degrees : degrees;
}

/// The answer, or nothing if any length, kind or check in it is wrong.
inline std::optional<PlainExBusAnswer> plain_exbus_answer(std::span<const std::uint8_t> frame) {
    const auto outer = plain_exbus_frame(frame, 0);
    if (!outer || outer->length != frame.size() || frame[0] != 0x3B || frame[1] != 0x01 ||
        frame[4] != 0x3A) {
        return std::nullopt;
    }
    const auto message = frame.subspan(6, frame.size() - 8);
    if (message.size() < 9 || message[0] % 16 != 0x0F || message[1] % 64U + 2 != message.size() ||
        plain_ex_check(message.subspan(1, message.size() - 2)) != message.back()) {
        return std::nullopt;
    }
    PlainExBusAnswer answer;
    answer.packet = frame[3];
    answer.device = message[4] + 256U * message[5];
    const auto content = message.subspan(7, message.size() - 8);
    if (message[1] / 64 == 0) {
        const std::size_t label = content[1] / 8;
        const std::size_t unit = content[1] % 8;
        if (content.size() != 2 + label + unit) {
            return std::nullopt;
        }
        answer.named = content[0];
        answer.label.assign(content.begin() + 2, content.end() - static_cast<int>(unit));
        answer.unit.assign(content.end() - static_cast<int>(unit), content.end());
        return answer;
    }
    const std::map<unsigned, std::size_t> bytes_of{{0, 1}, {1, 2}, {4, 3}, {8, 4}, {9, 4}};
    for (std::size_t at = 0; at < content.size();) {
        const auto kind = bytes_of.find(content[at] % 16);
        if (kind == bytes_of.end() || at + 1 + kind->second > content.size()) {
            return std::nullopt;
        }
        const auto number = content.subspan(at + 1, kind->second);
        answer.numbers[content[at] / 16] =
            kind->first == 9 ? plain_ex_position(number) : plain_ex_decimal(number);
        at += 1 + kind->second;
    }
    return answer;
}

/// A receiver's request for telemetry.
inline std::vector<std::uint8_t> plain_exbus_request(std::uint8_t packet,
                                                     std::uint8_t kind = 0x3A) {
    std::vector<std::uint8_t> frame{0x3D, 0x01, 0x08, packet, kind, 0x00};
    const unsigned check = plain_exbus_check(frame);
    frame.push_back(static_cast<std::uint8_t>(check % 256));
    frame.push_back(static_cast<std::uint8_t>(check / 256));
    return frame;
}

}  // namespace tribus::reference
