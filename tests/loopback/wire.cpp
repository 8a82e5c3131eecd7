#include "tests/loopback/wire.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "tests/support/ibus_checksum.h"

namespace tribus::test {
namespace {

constexpr std::size_t kIbusLength = 32;
constexpr std::size_t kIbusSlots = 14;
constexpr std::size_t kSbusLength = 25;
constexpr std::size_t kSbusBits = 11;

unsigned slot(std::span<const std::uint8_t> frame, std::size_t index) {
    return frame[2 + 2 * index] | static_cast<unsigned>(frame[3 + 2 * index]) << 8U;
}

bool is_ibus(std::span<const std::uint8_t> frame) {
    return frame[0] == 0x20 && frame[1] == 0x40 &&
           ibus_checksum(frame.first(kIbusLength - 2)) == slot(frame, kIbusSlots);
}

Sticks parse_ibus(std::span<const std::uint8_t> frame) {
    Sticks sticks;
    bool nibbles = false;
    for (std::size_t i = 0; i < kIbusSlots; ++i) {
        sticks.push_back(static_cast<int>(slot(frame, i) & 0xFFFU));
        nibbles = nibbles || slot(frame, i) > 0xFFF;
    }
    for (std::size_t extra = 0; nibbles && extra < 4; ++extra) {
        unsigned value = 0;
        for (std::size_t part = 0; part < 3; ++part) {
            value |= (slot(frame, 3 * extra + part) >> 12U) << (4 * part);
        }
        sticks.push_back(static_cast<int>(value));
    }
    return sticks;
}

bool is_sbus(std::span<const std::uint8_t> frame) {
    return frame[0] == 0x0F && (frame[23] & 0xF0U) == 0 && frame[24] == 0;
}

SbusSight parse_sbus_frame(std::span<const std::uint8_t> frame) {
    SbusSight sight;
    for (std::size_t bit = 0; bit < kSbusBits * sight.raw.size(); ++bit) {
        const int value = frame[1 + bit / 8] >> (bit % 8) & 1;
        sight.raw[bit / kSbusBits] |= value << (bit % kSbusBits);
    }
    sight.channel_17 = (frame[23] & 1U) != 0;
    sight.channel_18 = (frame[23] & 2U) != 0;
    sight.frame_lost = (frame[23] & 4U) != 0;
    sight.failsafe = (frame[23] & 8U) != 0;
    sight.seen = Clock::now();
    return sight;
}

/// Moves complete frames out of the front of `pending`. A byte that starts no frame is a stray
/// byte.
template <class IsFrame, class Take>
void cut(Bytes& pending, std::size_t length, std::size_t& strays, IsFrame is_frame, Take take) {
    std::size_t start = 0;
    while (pending.size() - start >= length) {
        const std::span<const std::uint8_t> frame(pending.data() + start, length);
        if (is_frame(frame)) {
            take(frame);
            start += length;
        } else {
            ++strays;
            ++start;
        }
    }
    pending.erase(pending.begin(), pending.begin() + static_cast<std::ptrdiff_t>(start));
}

}  // namespace

Sticks sticks_with_first(int first_us, std::size_t channels) {
    Sticks sticks(channels, 1500);
    sticks[0] = first_us;
    return sticks;
}

Bytes ibus_bytes(const Sticks& sticks) {
    Bytes frame{0x20, 0x40};
    for (std::size_t i = 0; i < kIbusSlots; ++i) {
        auto word = static_cast<unsigned>(sticks[i]);
        const std::size_t extra = kIbusSlots + i / 3;
        if (extra < sticks.size()) {
            word |= (static_cast<unsigned>(sticks[extra]) >> (4 * (i % 3)) & 0xFU) << 12U;
        }
        frame.push_back(static_cast<std::uint8_t>(word & 0xFFU));
        frame.push_back(static_cast<std::uint8_t>(word >> 8U));
    }
    const unsigned checksum = ibus_checksum(frame);
    frame.push_back(static_cast<std::uint8_t>(checksum & 0xFFU));
    frame.push_back(static_cast<std::uint8_t>(checksum >> 8U));
    return frame;
}

Bytes sbus_bytes(const SbusSight& sight) {
    Bytes frame(kSbusLength);
    frame[0] = 0x0F;
    for (std::size_t bit = 0; bit < kSbusBits * sight.raw.size(); ++bit) {
        const auto raw = static_cast<unsigned>(sight.raw[bit / kSbusBits]);
        const unsigned value = raw >> (bit % kSbusBits) & 1U;
        frame[1 + bit / 8] |= static_cast<std::uint8_t>(value << (bit % 8));
    }
    frame[23] = static_cast<std::uint8_t>((sight.channel_17 ? 1 : 0) | (sight.channel_18 ? 2 : 0) |
                                          (sight.frame_lost ? 4 : 0) | (sight.failsafe ? 8 : 0));
    return frame;
}

int sbus_raw(int us) {
    return std::clamp(static_cast<int>(std::lround((us - 880) * 8 / 5.0)), 0, 2047);
}

SbusSight sbus_sight_of(const Sticks& sticks) {
    SbusSight sight;
    for (std::size_t i = 0; i < sight.raw.size(); ++i) {
        sight.raw[i] = sbus_raw(i < sticks.size() ? sticks[i] : 1500);
    }
    sight.channel_17 = sticks.size() > 16 && sticks[16] > 1500;
    sight.channel_18 = sticks.size() > 17 && sticks[17] > 1500;
    return sight;
}

bool same_channels(const SbusSight& a, const SbusSight& b) {
    return a.raw == b.raw && a.channel_17 == b.channel_17 && a.channel_18 == b.channel_18;
}

std::vector<SbusSight> ServoBank::listen() {
    const Bytes fresh = wire_.receive();
    pending_.insert(pending_.end(), fresh.begin(), fresh.end());
    std::vector<SbusSight> sights;
    cut(pending_, kSbusLength, strays_, is_sbus,
        [&](auto frame) { sights.push_back(parse_sbus_frame(frame)); });
    return sights;
}

std::vector<Sticks> IbusReader::listen() {
    const Bytes fresh = wire_.receive();
    pending_.insert(pending_.end(), fresh.begin(), fresh.end());
    std::vector<Sticks> frames;
    cut(pending_, kIbusLength, strays_, is_ibus,
        [&](auto frame) { frames.push_back(parse_ibus(frame)); });
    return frames;
}

}  // namespace tribus::test
