#include "transports/links/parity_marks.h"

namespace tribus {

namespace {

constexpr std::uint8_t kMark = 0xFF;
constexpr std::uint8_t kDamageFollows = 0x00;

void append(std::uint8_t byte, bool damaged, Reception& reception) {
    reception.bytes[reception.count] = byte;
    reception.damaged.set(reception.count, damaged);
    ++reception.count;
}

}  // namespace

void ParityMarks::take(std::span<const std::uint8_t> raw, Reception& reception) {
    for (const std::uint8_t byte : raw) {
        if (reception.count == reception.bytes.size()) {
            return;
        }
        take_byte(byte, reception);
    }
}

void ParityMarks::take_byte(std::uint8_t byte, Reception& reception) {
    switch (place_) {
        case Place::plain:
            if (byte == kMark) {
                place_ = Place::after_mark;
            } else {
                append(byte, false, reception);
            }
            return;
        case Place::after_mark:
            if (byte == kDamageFollows) {
                place_ = Place::before_damaged;
                return;
            }
            // The kernel puts nothing but FF or 00 here. Should another byte come, a byte is
            // missing in between: not to be trusted.
            append(byte, byte != kMark, reception);
            place_ = Place::plain;
            return;
        case Place::before_damaged:
            append(byte, true, reception);
            place_ = Place::plain;
            return;
    }
}

}  // namespace tribus
