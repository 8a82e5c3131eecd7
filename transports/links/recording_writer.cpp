#include "transports/links/recording_writer.h"

namespace tribus {
namespace {

void append_byte(std::string& text, std::uint8_t byte) {
    constexpr std::string_view kDigits = "0123456789abcdef";
    text += kDigits[byte >> 4U];
    text += kDigits[byte & 0xFU];
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
    text += std::to_string(std::chrono::round<std::chrono::microseconds>(start).count());
    text += ' ';
    append_hex_line(text, bytes);
}

}  // namespace tribus
