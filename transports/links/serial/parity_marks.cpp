#include "transports/links/serial/parity_marks.h"

#include <cassert>
#include <cstring>

namespace tribus {

namespace {

constexpr std::uint8_t kMark = 0xFF;
constexpr std::uint8_t kDamageFollows = 0x00;

void append_byte(std::uint8_t byte, bool damaged, Reception& reception) {
    reception.bytes[reception.count] = byte;
    reception.damaged.set(reception.count, damaged);
    ++reception.count;
}

}  // namespace

void ParityMarks::take(std::span<const std::uint8_t> raw, Reception& reception) {
    while (!raw.empty()) {
        if (place_ == Place::plain) {
            raw = take_until_mark(raw, reception);
        }
        if (!raw.empty()) {
            take_byte(raw.front(), reception);
            raw = raw.subspan(1);
        }
    }
}

void ParityMarks::remove(std::size_t raw, Reception& reception) {
    if (place_ == Place::plain && std::memchr(reception.bytes.data(), kMark, raw) == nullptr) {
        reception.count = raw;
        return;
    }
    // Removing marks only shortens the bytes, so they fit.
    const auto marked = reception.bytes;
    take(std::span(marked).first(raw), reception);
}

std::span<const std::uint8_t> ParityMarks::take_until_mark(std::span<const std::uint8_t> raw,
                                                           Reception& reception) {
    const void* mark = std::memchr(raw.data(), kMark, raw.size());
    const std::size_t plain =
        mark != nullptr
            ? static_cast<std::size_t>(static_cast<const std::uint8_t*>(mark) - raw.data())
            : raw.size();
    std::memcpy(reception.bytes.data() + reception.count, raw.data(), plain);
    reception.count += plain;
    return raw.subspan(plain);
}

void ParityMarks::take_byte(std::uint8_t byte, Reception& reception) {
    switch (place_) {
        case Place::plain:
            assert(byte == kMark);  // `take_until_mark` has taken the others
            place_ = Place::after_mark;
            break;
        case Place::after_mark:
            if (byte == kDamageFollows) {
                place_ = Place::before_damaged;
                return;
            }
            // The kernel puts only FF or 00 here. Before any other byte, one is missing, so it is
            // marked as damaged.
            append_byte(byte, byte != kMark, reception);
            place_ = Place::plain;
            break;
        case Place::before_damaged:
            append_byte(byte, true, reception);
            place_ = Place::plain;
            break;
    }
}

}  // namespace tribus
