#include <array>
#include <numeric>

#include "transports/codecs/ibus.h"
#include "transports/codecs/ibus_wire.h"

namespace tribus {

using namespace ibus_wire;

namespace {

constexpr std::uint8_t kIa6Header = 0x55;
constexpr std::size_t kIa6Length = 31;
constexpr std::size_t kIa6SlotsAt = 1;

// i-BUS2 (AFHDS 3, another protocol): the two low bits of the first byte are the packet type, 0
// for channels, the next four its subtype (0 to 2 in use); then the length; a CRC-8 with
// polynomial 0x25 and start value 0xFF ends it. Facts: ArduPilot AP_IBus2, from FlySky's document
// V2.4 and captures of a FTr8B (the start value; Betaflight has 0, which the captures refute).
constexpr std::uint8_t kIbus2TypeMask = 0x03;
constexpr unsigned kIbus2SubtypeShift = 2;
constexpr std::uint8_t kIbus2SubtypeMask = 0x0F;
constexpr std::uint8_t kIbus2LastSubtype = 2;
constexpr std::size_t kIbus2Shortest = 8;
constexpr std::size_t kIbus2Longest = 37;
constexpr std::uint8_t kIbus2Polynomial = 0x25;
constexpr std::uint8_t kIbus2CrcStart = 0xFF;

static_assert(kIa6SlotsAt + 2 * kSlotCount + kChecksumBytes == kIa6Length);

std::uint16_t word_at(std::span<const std::uint8_t> bytes, std::size_t position) {
    return static_cast<std::uint16_t>(bytes[position] | bytes[position + 1] << 8);
}

constexpr std::uint16_t kLongFrameHeader = kLongestFrame | kServoCommand << 8U;

/// Of at most 32 bytes.
unsigned sum_of(std::span<const std::uint8_t> bytes) {
    std::uint64_t words = 0;
    for (; bytes.size() >= kGroupBytes; bytes = bytes.subspan(kGroupBytes)) {
        words += sum_by_words(load_word(bytes.data()));
    }
    return std::accumulate(bytes.begin(), bytes.end(), total(words));
}

/// 0xFFFF less each byte before the checksum (1.2).
std::uint16_t servo_checksum(std::span<const std::uint8_t> body) {
    return static_cast<std::uint16_t>(0xFFFF - sum_of(body));
}

/// A whole frame of 32 bytes, whose checksum is the upper half of its last group.
bool long_frame_holds(std::span<const std::uint8_t, kLongestFrame> wire) {
    std::uint64_t words = 0;
    for (std::size_t at = 0; at < kLongestFrame - kGroupBytes; at += kGroupBytes) {
        words += sum_by_words(load_word(&wire[at]));
    }
    const std::uint64_t last = load_word(&wire[kLongestFrame - kGroupBytes]);
    words += sum_by_words(last & 0x0000FFFF'FFFFFFFF);
    return total(words) + (last >> 48U) == 0xFFFF;
}

/// The sum of the 14 words, without the header (1.6). Words beyond 12 bits are no channel: the
/// plain sum is weak, and this keeps noise out.
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

/// What a byte does to the CRC of i-BUS2 when so many more bytes follow it as the index says.
using CrcTables = std::array<std::array<std::uint8_t, 256>, kGroupBytes>;
constexpr CrcTables kIbus2Crc = [] {
    CrcTables tables{};
    for (unsigned byte = 0; byte < 256; ++byte) {
        unsigned crc = byte;
        for (int bit = 0; bit < 8; ++bit) {
            crc = crc << 1U ^ ((crc & 0x80U) != 0 ? kIbus2Polynomial : 0U);
        }
        tables[0][byte] = static_cast<std::uint8_t>(crc);
    }
    for (std::size_t behind = 1; behind < tables.size(); ++behind) {
        for (std::size_t byte = 0; byte < 256; ++byte) {
            tables[behind][byte] = tables[0][tables[behind - 1][byte]];
        }
    }
    return tables;
}();

bool ibus2_holds(std::span<const std::uint8_t> frame) {
    std::uint8_t crc = kIbus2CrcStart;
    const std::uint8_t* at = frame.data();
    const std::uint8_t* const end = at + frame.size() - 1;
    const auto& crc_of = kIbus2Crc;
    for (; end - at >= 8; at += 8) {
        crc = crc_of[7][at[0] ^ crc] ^ crc_of[6][at[1]] ^ crc_of[5][at[2]] ^ crc_of[4][at[3]] ^
              crc_of[3][at[4]] ^ crc_of[2][at[5]] ^ crc_of[1][at[6]] ^ crc_of[0][at[7]];
    }
    if (end - at >= 4) {
        crc = crc_of[3][at[0] ^ crc] ^ crc_of[2][at[1]] ^ crc_of[1][at[2]] ^ crc_of[0][at[3]];
        at += 4;
    }
    for (; at != end; ++at) {
        crc = crc_of[0][*at ^ crc];
    }
    return crc == *end;
}

constexpr bool is_servo_length(std::uint8_t first) {
    return first >= kShortestFrame && first <= kLongestFrame && first % 2 == 0;
}

constexpr bool may_be_ibus2(std::uint8_t first) {
    return (first & kIbus2TypeMask) == 0 &&
           ((first >> kIbus2SubtypeShift) & kIbus2SubtypeMask) <= kIbus2LastSubtype;
}

// What may begin with a byte.
constexpr std::uint8_t kServo = 1;
constexpr std::uint8_t kIa6 = 2;
constexpr std::uint8_t kIbus2Channels = 4;
constexpr auto kBegins = [] {
    std::array<std::uint8_t, 256> begins{};
    for (unsigned value = 0; value < begins.size(); ++value) {
        const auto first = static_cast<std::uint8_t>(value);
        begins[value] = static_cast<std::uint8_t>((is_servo_length(first) ? kServo : 0U) |
                                                  (first == kIa6Header ? kIa6 : 0U) |
                                                  (may_be_ibus2(first) ? kIbus2Channels : 0U));
    }
    return begins;
}();

bool is_servo_command(std::uint8_t first, std::uint8_t second) {
    return second == kServoCommand || (first == kLongestFrame && second == kBetaflightTestCommand);
}

void put_slots(ChannelFrame& channels, std::span<const std::uint8_t> slots, std::uint16_t mask) {
    for (std::size_t slot = 0; 2 * slot < slots.size(); ++slot) {
        channels.set(slot, Pulse::from_microseconds(word_at(slots, 2 * slot) & mask));
    }
}

/// All 14 slots, 12 bits each, microseconds to eighths.
inline void put_all_slots(ChannelFrame& channels, const std::uint8_t* slots) {
    constexpr unsigned kEighthsBits = 3;
    constexpr std::size_t kLast = kSlotCount - kLanes;
    auto& pulses = channels.pulses();
    // The last eight slots begin with two of the first eight.
    store_numbers(&pulses[0], (load_wire(slots) & kChannelMask) << kEighthsBits);
    store_numbers(&pulses[kLast], (load_wire(slots + 2 * kLast) & kChannelMask) << kEighthsBits);
    channels.mark_first(kSlotCount);
}

/// The three nibbles of a channel stand on top of three slots, the lowest first. The factor brings
/// each to its place in one number.
void put_nibble_channels(ChannelFrame& channels, const std::uint8_t* slots) {
    constexpr std::uint64_t kTogether = 1ULL << 36U | 1ULL << 24U | 1ULL << 12U;
    constexpr std::uint64_t kThreeNibbles = kNibbles & 0x0000FFFF'FFFFFFFF;
    for (std::size_t extra = 0; extra < kNibbleChannels; ++extra) {
        const std::uint64_t three = load_word(slots + 2 * kNibblesPerChannel * extra);
        const std::uint64_t value = ((three & kThreeNibbles) * kTogether) >> 48U;
        if (value != 0) {
            channels.set(kSlotCount + extra,
                         Pulse::from_eighths(static_cast<std::int16_t>(value * 8)));
        }
    }
}

}  // namespace

inline bool IbusDecoder::may_begin(std::uint8_t first) const {
    return first == kIa6Header || is_servo_length(first) || (!frame_seen_ && may_be_ibus2(first));
}

/// What stands at the front of what there is, if `begins` may.
inline IbusDecoder::Candidate IbusDecoder::candidate(std::uint8_t begins,
                                                     std::span<const std::uint8_t> bytes) {
    if (begins == kIa6) {
        return {Kind::ia6, kIa6Length};
    }
    if (bytes.size() < 2) {
        return {Kind::undecided, 2};
    }
    const std::uint8_t second = bytes[1];
    if ((begins & kServo) != 0 && is_servo_command(bytes[0], second)) {
        return {Kind::servo, bytes[0]};
    }
    if ((begins & kIbus2Channels) != 0 && second >= kIbus2Shortest && second <= kIbus2Longest) {
        return {Kind::ibus2, second};
    }
    return {};
}

inline bool IbusDecoder::checksum_holds(Kind kind, std::span<const std::uint8_t> frame) {
    switch (kind) {
        case Kind::servo: {
            if (frame.size() == kLongestFrame) {
                return long_frame_holds(frame.first<kLongestFrame>());
            }
            const std::size_t body = frame.size() - kChecksumBytes;
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

inline void IbusDecoder::read_frame(std::span<const std::uint8_t> wire, std::size_t slots_at,
                                    Instant received, DecodedFrame& frame) {
    frame = {.first_byte = buffer_.first_position(), .length = wire.size()};
    frame.channels.frame_lost = false;
    frame.channels.failsafe = false;
    frame.channels.received = received;
    frame.channels.origin = Origin::ibus;
    const auto slots = wire.subspan(slots_at, wire.size() - slots_at - kChecksumBytes);
    if (slots_ == IbusSlots::plain) {
        put_slots(frame.channels, slots, 0xFFFF);
    } else if (wire.size() == kLongestFrame) {
        put_all_slots(frame.channels, slots.data());
        put_nibble_channels(frame.channels, slots.data());
    } else {
        put_slots(frame.channels, slots, kChannelMask);
    }
    frame_seen_ = true;
}

void IbusDecoder::damaged_byte() {
    buffer_.append_damaged();
    ++rejected_[kDamaged].count;
}

/// Judges what begins at `position` or behind it and before `end`; `damage` marks the first bytes.
/// Says what stands at the position that it has come to then: a frame, one that is not there as a
/// whole yet, or noise, if nothing is left.
inline IbusDecoder::Candidate IbusDecoder::find_frame(std::span<const std::uint8_t> bytes,
                                                      std::size_t end, std::uint64_t damage,
                                                      std::size_t& position) {
    // Waiting for an i-BUS2 frame to end may take longer than the next i.Bus frame needs, so it is
    // looked for only on a line that has not shown i.Bus yet: a line speaks one of the two.
    const std::uint8_t looked_for = frame_seen_ ? kServo | kIa6 : kServo | kIa6 | kIbus2Channels;
    std::size_t at = position;
    Candidate found;
    for (; at < end; ++at) {
        const std::uint8_t begins = kBegins[bytes[at]] & looked_for;
        if (begins == 0 || (damage != 0 && (damage >> at & 1U) != 0)) {
            continue;
        }
        found = candidate(begins, bytes.subspan(at));
        if (found.kind == Kind::noise) {
            continue;
        }
        if (found.length > bytes.size() - at) {
            found.whole = false;
            break;
        }
        if (damage != 0 && (damage >> at & ((std::uint64_t{1} << found.length) - 1)) != 0) {
            continue;
        }
        if (checksum_holds(found.kind, bytes.subspan(at, found.length))) {
            if (found.kind != Kind::ibus2) {
                break;
            }
            ++rejected_[kIbus2].count;
            at += found.length - 1;
        } else if (found.kind == Kind::servo) {
            ++rejected_[kChecksum].count;
        }
    }
    skipped_bytes_ += at;
    position = at;
    return at < end ? found : Candidate{};
}

IbusDecoder::Taken IbusDecoder::decode(std::span<const std::uint8_t> bytes, Instant received,
                                       DecodedFrame& frame) {
    // What usually comes is a frame in its place, in one read; the rest comes to the same.
    if (buffer_.size() == 0 && bytes.size() >= kLongestFrame) {
        const auto wire = bytes.first<kLongestFrame>();
        if (word_at(wire, 0) == kLongFrameHeader && long_frame_holds(wire)) {
            read_frame(wire, kSlotsAt, received, frame);
            buffer_.pass(kLongestFrame);
            return {kLongestFrame, true};
        }
    }
    if (bytes.size() == 1 && !buffer_.any_damaged()) {
        return decode_byte(bytes, received, frame);
    }
    return buffer_.size() == 0 || !buffer_.any_damaged() ? decode_pieces(bytes, received, frame)
                                                         : search_kept(bytes, received, frame);
}

/// The bytes of a long frame that decide something: the first two and the last. Not inline, nor is
/// the next: the usual case needs no registers saved.
[[gnu::noinline]] IbusDecoder::Taken IbusDecoder::decode_byte(std::span<const std::uint8_t> bytes,
                                                              Instant received,
                                                              DecodedFrame& frame) {
    const std::uint8_t byte = bytes[0];
    const std::span<const std::uint8_t, kLongestFrame> wire(buffer_.kept(), kLongestFrame);
    if (buffer_.size() == 0 && byte == kLongestFrame) {
        buffer_.keep_one(byte, 1);
        return {1, false};
    }
    if (buffer_.size() == 0 && !may_begin(byte)) {
        buffer_.pass(1);
        ++skipped_bytes_;
        return {1, false};
    }
    if (buffer_.size() == 1 && wire[0] == kLongestFrame && byte == kServoCommand) {
        buffer_.keep_one(byte, kLongestFrame - kSlotsAt);
        return {1, false};
    }
    if (buffer_.size() == kLongestFrame - 1 && word_at(wire, 0) == kLongFrameHeader) {
        buffer_.keep_one(byte, 0);
        if (long_frame_holds(wire)) {
            read_frame(wire, kSlotsAt, received, frame);
            buffer_.pass_kept();
            return {1, true};
        }
        return search_last(received, frame);
    }
    return buffer_.size() == 0 ? decode_pieces(bytes, received, frame)
                               : search_kept(bytes, received, frame);
}

/// What shows by its first byte that no frame begins here.
inline void IbusDecoder::pass_noise(std::span<const std::uint8_t>& bytes) {
    std::size_t noise = 0;
    while (noise < bytes.size() && !may_begin(bytes[noise])) {
        ++noise;
    }
    bytes = bytes.subspan(noise);
    buffer_.pass(noise);
    skipped_bytes_ += noise;
}

[[gnu::noinline]] IbusDecoder::Taken IbusDecoder::decode_pieces(std::span<const std::uint8_t> bytes,
                                                                Instant received,
                                                                DecodedFrame& frame) {
    auto rest = bytes;
    if (buffer_.size() == 0) {
        pass_noise(rest);
        if (rest.empty()) {
            return {bytes.size(), false};
        }
    }
    const bool found = !buffer_.any_damaged() && buffer_.peek(0, rest) == kLongestFrame
                           ? decode_long(rest, received, frame)
                           : search(rest, 0, received, frame);
    return {bytes.size() - rest.size(), found};
}

/// A frame of 32 bytes in several reads.
inline bool IbusDecoder::decode_long(std::span<const std::uint8_t>& bytes, Instant received,
                                     DecodedFrame& frame) {
    if (!buffer_.reaches(kSlotsAt, bytes)) {
        return false;
    }
    if (buffer_.peek(1, bytes) != kServoCommand) {
        return search(bytes, 0, received, frame);
    }
    if (!buffer_.reaches(kLongestFrame, bytes)) {
        return false;
    }
    const std::span<const std::uint8_t, kLongestFrame> wire(buffer_.whole(kLongestFrame, bytes),
                                                            kLongestFrame);
    if (!long_frame_holds(wire)) {
        return search_behind(bytes, received, frame);
    }
    read_frame(wire, kSlotsAt, received, frame);
    buffer_.pass(kLongestFrame, bytes);
    return true;
}

/// The same, with its last byte the last one that there is.
[[gnu::noinline]] IbusDecoder::Taken IbusDecoder::search_last(Instant received,
                                                              DecodedFrame& frame) {
    std::span<const std::uint8_t> nothing_more;
    return {1, search_behind(nothing_more, received, frame)};
}

[[gnu::noinline]] IbusDecoder::Taken IbusDecoder::search_kept(std::span<const std::uint8_t> bytes,
                                                              Instant received,
                                                              DecodedFrame& frame) {
    auto rest = bytes;
    const bool found = search(rest, 0, received, frame);
    return {bytes.size() - rest.size(), found};
}

/// A long frame at the front is none.
[[gnu::noinline]] bool IbusDecoder::search_behind(std::span<const std::uint8_t>& bytes,
                                                  Instant received, DecodedFrame& frame) {
    ++rejected_[kChecksum].count;
    return search(bytes, 1, received, frame);
}

/// Judges all from `start` on, which is behind the front by no more than a byte.
bool IbusDecoder::search(std::span<const std::uint8_t>& bytes, std::size_t start, Instant received,
                         DecodedFrame& frame) {
    const std::size_t kept = buffer_.size();
    if (kept == 0) {
        return judge({bytes, bytes.size(), start}, bytes, received, frame) == Outcome::frame;
    }
    const auto joined = buffer_.join(bytes, kIbus2Longest - 1);
    const Window window{joined, kept, start, buffer_.damage().from(0)};
    const Outcome outcome = judge(window, bytes, received, frame);
    if (outcome != Outcome::nothing || bytes.empty()) {
        return outcome == Outcome::frame;
    }
    return judge({bytes, bytes.size(), 0}, bytes, received, frame) == Outcome::frame;
}

IbusDecoder::Outcome IbusDecoder::judge(const Window& window, std::span<const std::uint8_t>& read,
                                        Instant received, DecodedFrame& frame) {
    std::size_t position = window.start;
    const Candidate found = find_frame(window.bytes, window.end, window.damage, position);
    if (found.kind == Kind::noise) {
        buffer_.pass(position, read);
        return Outcome::nothing;
    }
    if (!found.whole) {
        buffer_.hold(window.bytes.subspan(position), position, found.length);
        read = {};
        return Outcome::wait;
    }
    read_frame(window.bytes.subspan(position, found.length),
               found.kind == Kind::ia6 ? kIa6SlotsAt : kSlotsAt, received, frame);
    frame.first_byte += position;
    buffer_.pass(position + found.length, read);
    return Outcome::frame;
}

}  // namespace tribus
