#include "tests/reference/plain_ibus.h"

#include <algorithm>
#include <numeric>

namespace tribus::reference {
namespace {

constexpr std::size_t kSlotCount = 14;
constexpr std::size_t kSlotsAt = 2;
constexpr std::size_t kChecksumBytes = 2;
constexpr std::size_t kShortestFrame = 6;
constexpr std::size_t kLongestFrame = 32;
constexpr std::uint8_t kServoCommand = 0x40;
constexpr std::uint8_t kBetaflightTestCommand = 0x00;
constexpr std::uint16_t kChannelMask = 0x0FFF;
constexpr unsigned kNibbleShift = 12;
constexpr std::size_t kNibblesPerChannel = 3;
constexpr std::size_t kNibbleChannels = kChannelCount - kSlotCount;

constexpr std::uint8_t kIa6Header = 0x55;
constexpr std::size_t kIa6Length = 31;
constexpr std::size_t kIa6SlotsAt = 1;

// i-BUS2 (AFHDS 3) is another protocol. The two low bits of the first byte are the packet type (0
// for channels), the next four bits its subtype (0 to 2 in use). The length follows. The last byte
// is a CRC-8 with polynomial 0x25 and start value 0xFF. Facts: ArduPilot AP_IBus2, from FlySky's
// document V2.4 and captures of a FTr8B (the start value; Betaflight has 0, which the captures
// refute).
constexpr std::uint8_t kIbus2TypeMask = 0x03;
constexpr unsigned kIbus2SubtypeShift = 2;
constexpr std::uint8_t kIbus2SubtypeMask = 0x0F;
constexpr std::uint8_t kIbus2LastSubtype = 2;
constexpr std::size_t kIbus2Shortest = 8;
constexpr std::size_t kIbus2Longest = 37;
constexpr std::uint8_t kIbus2Polynomial = 0x25;
constexpr std::uint8_t kIbus2CrcStart = 0xFF;

static_assert(kSlotsAt + 2 * kSlotCount + kChecksumBytes == kLongestFrame);
static_assert(kIa6SlotsAt + 2 * kSlotCount + kChecksumBytes == kIa6Length);
static_assert(kNibbleChannels * kNibblesPerChannel <= kSlotCount);

std::uint16_t word_at(std::span<const std::uint8_t> bytes, std::size_t position) {
    return static_cast<std::uint16_t>(bytes[position] | bytes[position + 1] << 8);
}

void put_word(std::span<std::uint8_t> bytes, std::size_t position, std::uint16_t word) {
    bytes[position] = static_cast<std::uint8_t>(word);
    bytes[position + 1] = static_cast<std::uint8_t>(word >> 8);
}

/// Returns 0xFFFF minus each byte before the checksum (docs/protocols/ibus.md, "Servo frame").
std::uint16_t servo_checksum(std::span<const std::uint8_t> body) {
    return static_cast<std::uint16_t>(std::accumulate(
        body.begin(), body.end(), 0xFFFF, [](int sum, int byte) { return sum - byte; }));
}

/// Returns whether the checksum is the sum of the 14 words without the header
/// (docs/protocols/ibus.md, "Variants"). Words of more than 12 bits are refused: the plain sum is
/// weak, and this keeps noise out.
bool ia6_holds(std::span<const std::uint8_t> frame) {
    unsigned sum = 0;
    for (std::size_t slot = 0; slot < kSlotCount; ++slot) {
        const std::uint16_t word = word_at(frame, kIa6SlotsAt + 2 * slot);
        if (word > kChannelMask) {
            return false;
        }
        sum += word;
    }
    return (sum & 0xFFFFU) == word_at(frame, kIa6Length - kChecksumBytes);
}

bool ibus2_holds(std::span<const std::uint8_t> frame) {
    std::uint8_t crc = kIbus2CrcStart;
    for (const std::uint8_t byte : frame.first(frame.size() - 1)) {
        crc ^= byte;
        for (int bit = 0; bit < 8; ++bit) {
            const bool carry = (crc & 0x80U) != 0;
            crc = static_cast<std::uint8_t>(crc << 1U);
            crc ^= carry ? kIbus2Polynomial : 0;
        }
    }
    return crc == frame.back();
}

bool may_be_ibus2(std::uint8_t first) {
    return (first & kIbus2TypeMask) == 0 &&
           ((first >> kIbus2SubtypeShift) & kIbus2SubtypeMask) <= kIbus2LastSubtype;
}

void put_slots(ChannelFrame& channels, std::span<const std::uint8_t> slots, std::uint16_t mask) {
    for (std::size_t slot = 0; 2 * slot < slots.size(); ++slot) {
        channels.set(slot, Pulse::from_microseconds(word_at(slots, 2 * slot) & mask));
    }
}

void put_nibble_channels(ChannelFrame& channels, std::span<const std::uint8_t> slots) {
    for (std::size_t extra = 0; extra < kNibbleChannels; ++extra) {
        unsigned value = 0;
        for (std::size_t part = 0; part < kNibblesPerChannel; ++part) {
            const std::size_t slot = kNibblesPerChannel * extra + part;
            const unsigned nibble = word_at(slots, 2 * slot) >> kNibbleShift;
            value |= nibble << (4U * part);
        }
        if (value != 0) {
            channels.set(kSlotCount + extra, Pulse::from_microseconds(value));
        }
    }
}

std::uint16_t wire_microseconds(Pulse pulse) {
    return static_cast<std::uint16_t>(
        std::clamp<std::int32_t>(pulse.whole_microseconds(), 0, kChannelMask));
}

}  // namespace

PlainIbusDecoder::Candidate PlainIbusDecoder::candidate() const {
    if (buffer_.damaged(0)) {
        return {};
    }
    const std::uint8_t first = buffer_[0];
    if (first == kIa6Header) {
        return {Kind::ia6, kIa6Length};
    }
    const bool servo_length = first >= kShortestFrame && first <= kLongestFrame && first % 2 == 0;
    // An i-BUS2 frame may take longer to end than the next i.Bus frame. A line carries only one of
    // the two protocols, so i-BUS2 is looked for only until the line has shown i.Bus.
    const bool maybe_ibus2 = usual_length_ == 0 && may_be_ibus2(first);
    if (!servo_length && !maybe_ibus2) {
        return {};
    }
    if (buffer_.size() < 2) {
        return {Kind::undecided, 2};
    }
    const std::uint8_t second = buffer_[1];
    if (servo_length &&
        (second == kServoCommand || (first == kLongestFrame && second == kBetaflightTestCommand))) {
        return {Kind::servo, first};
    }
    if (maybe_ibus2 && second >= kIbus2Shortest && second <= kIbus2Longest) {
        return {Kind::ibus2, second};
    }
    return {};
}

bool PlainIbusDecoder::checksum_holds(const Candidate& candidate) const {
    const auto frame = buffer_.view(0, candidate.length);
    switch (candidate.kind) {
        case Kind::servo: {
            const std::size_t body = candidate.length - kChecksumBytes;
            return servo_checksum(frame.first(body)) == word_at(frame, body);
        }
        case Kind::ia6:
            return ia6_holds(frame);
        case Kind::ibus2:
            return ibus2_holds(frame);
        case Kind::noise:
        case Kind::undecided:
            break;
    }
    return false;
}

void PlainIbusDecoder::skip(std::size_t count) {
    buffer_.drop(count);
    skipped_bytes_ += count;
}

void PlainIbusDecoder::judge_bad(const Candidate& candidate) {
    if (candidate.kind == Kind::servo && !buffer_.damaged(0, candidate.length)) {
        ++rejected_[kChecksum].count;
    }
    skip(1);
}

DecodedFrame PlainIbusDecoder::take_frame(const Candidate& candidate, Instant received) {
    DecodedFrame frame{.first_byte = buffer_.first_position(), .length = candidate.length};
    frame.channels.frame_lost = false;
    frame.channels.failsafe = false;
    frame.channels.received = received;
    frame.channels.origin = Origin::ibus;
    const std::size_t slots_at = candidate.kind == Kind::ia6 ? kIa6SlotsAt : kSlotsAt;
    const auto slots = buffer_.view(slots_at, candidate.length - slots_at - kChecksumBytes);
    const bool nibbles = slots_ == IbusSlots::nibbles;
    put_slots(frame.channels, slots, nibbles ? kChannelMask : std::uint16_t{0xFFFF});
    if (nibbles && candidate.length == kLongestFrame) {
        put_nibble_channels(frame.channels, slots);
    }
    buffer_.drop(candidate.length);
    usual_length_ = candidate.length;
    others_in_a_row_ = 0;
    return frame;
}

void PlainIbusDecoder::damaged_byte() {
    buffer_.append_damaged();
    ++rejected_[kDamaged].count;
}

std::optional<DecodedFrame> PlainIbusDecoder::next(std::span<const std::uint8_t>& bytes,
                                                   Instant received) {
    while (true) {
        if (buffer_.size() == 0) {
            buffer_.take(bytes, 1);
            if (buffer_.size() == 0) {
                return std::nullopt;
            }
        }
        const Candidate found = candidate();
        if (found.kind == Kind::noise) {
            skip(1);
            continue;
        }
        if (buffer_.size() < found.length) {
            if (bytes.empty()) {
                return std::nullopt;
            }
            buffer_.take(bytes, found.length - buffer_.size());
            continue;
        }
        if (const auto frame = judge_whole(found, received)) {
            return frame;
        }
    }
}

/// Judges a candidate whose bytes are all in the buffer.
std::optional<DecodedFrame> PlainIbusDecoder::judge_whole(const Candidate& found,
                                                          Instant received) {
    if (buffer_.damaged(0, found.length) || !checksum_holds(found)) {
        judge_bad(found);
    } else if (found.kind == Kind::ibus2) {
        ++rejected_[kIbus2].count;
        skip(found.length);
    } else if (length_counts(found.length)) {
        return take_frame(found, received);
    } else {
        ++rejected_[kLength].count;
        skip(found.length);
    }
    return std::nullopt;
}

/// Returns whether frames of this length count. A length other than the usual one counts when it
/// has come three times in a row.
bool PlainIbusDecoder::length_counts(std::size_t length) {
    if (usual_length_ == 0 || length == usual_length_) {
        return true;
    }
    if (length != other_length_) {
        others_in_a_row_ = 0;
    }
    other_length_ = length;
    ++others_in_a_row_;
    return others_in_a_row_ == 3;
}

/// Judges what is in the buffer as if no more bytes would come.
std::optional<DecodedFrame> PlainIbusDecoder::silence() {
    while (buffer_.size() > 0) {
        const Candidate found = candidate();
        if (found.kind == Kind::noise || buffer_.size() < found.length) {
            skip(1);
        } else if (const auto frame = judge_whole(found, Instant{})) {
            return frame;
        }
    }
    return std::nullopt;
}

void PlainIbusDecoder::reset() {
    skip(buffer_.size());
    usual_length_ = 0;
    other_length_ = 0;
    others_in_a_row_ = 0;
}

std::size_t PlainIbusEncoder::encode(const ChannelFrame& frame,
                                     std::span<std::uint8_t, kLongestSerialFrame> wire) const {
    wire[0] = kLongestFrame;
    wire[1] = kServoCommand;
    for (std::size_t slot = 0; slot < kSlotCount; ++slot) {
        std::uint16_t word = wire_microseconds(frame.channel_or(slot, kCentrePulse));
        const std::size_t extra = kSlotCount + slot / kNibblesPerChannel;
        if (extra < channel_count_ && frame.has(extra)) {
            const unsigned value = wire_microseconds(frame.channel_or(extra, kCentrePulse));
            const unsigned nibble = (value >> (4U * (slot % kNibblesPerChannel))) & 0xFU;
            word = static_cast<std::uint16_t>(word | nibble << kNibbleShift);
        }
        put_word(wire, kSlotsAt + 2 * slot, word);
    }
    const std::size_t body = kLongestFrame - kChecksumBytes;
    put_word(wire, body, servo_checksum(wire.first(body)));
    return kLongestFrame;
}

}  // namespace tribus::reference
