#include "tests/sim/ibus_frames.h"

#include <algorithm>

#include "tests/support/ibus_checksum.h"

namespace tribus::test {
namespace {

constexpr std::size_t kHeaderBytes = 2;
constexpr std::size_t kChecksumBytes = 2;
constexpr std::uint8_t kServoCommand = 0x40;

unsigned word_at(std::span<const std::uint8_t> bytes, std::size_t position) {
    return bytes[position] | static_cast<unsigned>(bytes[position + 1]) << 8U;
}

/// The default of the key `plausible`.
bool is_of_a_stick(unsigned microseconds) {
    return microseconds >= 800 && microseconds <= 2200;
}

bool reads_as_good(std::span<const std::uint8_t> frame) {
    const std::size_t body = frame.size() - kChecksumBytes;
    if (frame[1] != kServoCommand || word_at(frame, body) != ibus_checksum(frame.first(body))) {
        return false;
    }
    for (std::size_t at = kHeaderBytes; at < body; at += 2) {
        if (!is_of_a_stick(word_at(frame, at) & 0x0FFFU)) {
            return false;
        }
    }
    return true;
}

}  // namespace

std::size_t shorten_ibus(std::span<std::uint8_t> bytes, const ChannelFrame& frame) {
    std::size_t count = 0;
    while (frame.has(count)) {
        ++count;
    }
    const std::size_t body = kHeaderBytes + 2 * count;
    bytes[0] = static_cast<std::uint8_t>(body + kChecksumBytes);
    const std::uint16_t checksum = ibus_checksum(bytes.first(body));
    bytes[body] = static_cast<std::uint8_t>(checksum);
    bytes[body + 1] = static_cast<std::uint8_t>(checksum >> 8U);
    return body + kChecksumBytes;
}

bool damage_is_hidden(std::span<const std::uint8_t> received, std::span<const std::uint8_t> sent) {
    for (std::size_t at = 0; at < received.size(); ++at) {
        const std::size_t length = received[at];
        if (length % 2 == 0 && length > kHeaderBytes + kChecksumBytes &&
            length <= received.size() - at) {
            const auto frame = received.subspan(at, length);
            if (reads_as_good(frame) && !std::ranges::equal(frame, sent)) {
                return true;
            }
        }
    }
    return false;
}

}  // namespace tribus::test
