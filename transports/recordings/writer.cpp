#include "transports/recordings/writer.h"

#include <algorithm>
#include <cstddef>

#include "transports/recordings/text.h"

namespace tribus {
namespace {

using recording_text::kCandumpZero;
using recording_text::kDamagedMark;

void append_byte(std::string& text, std::uint8_t byte) {
    constexpr std::string_view kDigits = "0123456789abcdef";
    text += kDigits[byte >> 4U];
    text += kDigits[byte & 0xFU];
}

/// In capital letters, as candump writes it.
void append_hex_number(std::string& text, std::uint32_t number, unsigned digits) {
    constexpr std::string_view kDigits = "0123456789ABCDEF";
    while (digits > 0) {
        --digits;
        text += kDigits[(number >> (4 * digits)) & 0xFU];
    }
}

void append_padded(std::string& text, std::int64_t number, std::size_t digits) {
    const std::string written = std::to_string(number);
    text.append(digits - std::min(digits, written.size()), '0').append(written);
}

/// `(0000000001.249713)`
void append_log_time(std::string& text, Duration at) {
    constexpr std::int64_t kMicrosecondsPerSecond = 1'000'000;
    const std::int64_t time = std::chrono::round<std::chrono::microseconds>(at).count();
    text += '(';
    append_padded(text, time / kMicrosecondsPerSecond, 10);
    text += '.';
    append_padded(text, time % kMicrosecondsPerSecond, 6);
    text += ')';
}

}  // namespace

void append_hex_line(std::string& text, std::span<const std::uint8_t> bytes) {
    for (std::size_t position = 0; position < bytes.size(); ++position) {
        if (position > 0) {
            text += ' ';
        }
        append_byte(text, bytes[position]);
    }
    text += '\n';
}

void append_timed_line(std::string& text, Duration start, std::span<const std::uint8_t> bytes) {
    append_timed_line(text, start, bytes, std::vector<bool>(bytes.size(), false));
}

void append_timed_line(std::string& text, Duration start, std::span<const std::uint8_t> bytes,
                       const std::vector<bool>& damaged) {
    text += std::to_string(std::chrono::round<std::chrono::microseconds>(start).count());
    for (std::size_t position = 0; position < bytes.size(); ++position) {
        text += ' ';
        append_byte(text, bytes[position]);
        if (damaged[position]) {
            text += kDamagedMark;
        }
    }
    text += '\n';
}

void append_candump_zero(std::string& text, Duration zero) {
    text.append(kCandumpZero);
    append_log_time(text, zero);
    text += '\n';
}

void append_candump_line(std::string& text, Duration at, std::string_view interface,
                         const CanFrame& frame) {
    append_log_time(text, at);
    text.append(" ").append(interface).append(" ");
    append_hex_number(text, frame.id, frame.extended ? 8 : 3);
    text += '#';
    if (frame.fd) {
        text += '#';
        append_hex_number(
            text, (frame.bit_rate_switch ? 1U : 0U) | (frame.error_state_indicator ? 2U : 0U), 1);
    }
    if (frame.remote) {
        text += 'R';
        text += frame.length > 0 ? std::to_string(frame.length) : std::string();
    } else {
        for (const std::uint8_t byte : frame.bytes()) {
            append_hex_number(text, byte, 2);
        }
    }
    text += '\n';
}

}  // namespace tribus
