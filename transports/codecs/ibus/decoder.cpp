#include <array>
#include <cassert>

#include "transports/codecs/ibus/checks.h"
#include "transports/codecs/ibus/ibus.h"
#include "transports/codecs/ibus/wire.h"

namespace tribus {

using namespace ibus_checks;
using namespace ibus_wire;

namespace {

void put_slots(ChannelFrame& channels, std::span<const std::uint8_t> slots, std::uint16_t mask) {
    for (std::size_t slot = 0; 2 * slot < slots.size(); ++slot) {
        channels.set(slot, Pulse::from_microseconds(word_at(slots, 2 * slot) & mask));
    }
}

/// Reads all 14 slots of 12 bits, from microseconds to eighths.
inline void put_all_slots(ChannelFrame& channels, const std::uint8_t* slots) {
    constexpr unsigned kEighthBits = 3;
    constexpr std::size_t kLast = kSlotCount - kLanes;
    auto& pulses = channels.pulses();
    // The last eight slots begin with two of the first eight.
    store_numbers(&pulses[0], (load_wire(slots) & kChannelMask) << kEighthBits);
    store_numbers(&pulses[kLast], (load_wire(slots + 2 * kLast) & kChannelMask) << kEighthBits);
    channels.mark_first(kSlotCount);
}

/// The three nibbles of a channel are the top nibbles of three slots, the lowest first. The
/// multiplication moves all of them to their places in one number.
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
    return first == kIa6Header || is_servo_length(first) ||
           (usual_length_ == 0 && may_be_ibus2(first));
}

/// Kind and length of the frame that may begin with the first byte. `begins`: the frames that the
/// byte allows.
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
            return ibus2_frame::crc_of(frame) == 0;
        case Kind::noise:
        case Kind::undecided:
            break;
    }
    return false;
}

inline void IbusDecoder::begin_frame(std::size_t length, Instant received, DecodedFrame& frame) {
    frame = {.first_byte = buffer_.first_position(), .length = length};
    frame.channels.frame_lost = false;
    frame.channels.failsafe = false;
    frame.channels.received = received;
    frame.channels.origin = Origin::ibus;
    usual_length_ = static_cast<std::uint16_t>(length);
}

[[gnu::always_inline]] inline void IbusDecoder::read_long_frame(
    std::span<const std::uint8_t, kLongFrame> wire, Instant received, DecodedFrame& frame) {
    begin_frame(kLongestFrame, received, frame);
    put_all_slots(frame.channels, wire.data() + kSlotsAt);
    put_nibble_channels(frame.channels, wire.data() + kSlotsAt);
}

[[gnu::noinline]] void IbusDecoder::read_frame(std::span<const std::uint8_t> wire,
                                               std::size_t slots_at, Instant received,
                                               DecodedFrame& frame) {
    if (slots_ == IbusSlots::nibbles && wire.size() == kLongestFrame) {
        read_long_frame(wire.first<kLongestFrame>(), received, frame);
        return;
    }
    begin_frame(wire.size(), received, frame);
    put_slots(frame.channels, wire.subspan(slots_at, wire.size() - slots_at - kChecksumBytes),
              slots_ == IbusSlots::plain ? std::uint16_t{0xFFFF} : kChannelMask);
}

/// Whether a frame of this length, with a correct checksum, is accepted.
[[gnu::noinline]] bool IbusDecoder::length_counts(std::size_t length) {
    constexpr std::uint8_t kInARow = 3;
    const auto now = static_cast<std::uint8_t>(length);
    const auto usual = static_cast<std::uint8_t>(usual_length_);
    if (usual != 0 && now != usual) {
        usual_length_ = now == other_length_ ? usual_length_ : usual;
        other_length_ = now;
        usual_length_ += kOneOther;
        if (usual_length_ < kInARow * kOneOther) {
            ++rejected_[kLength].count;
            return false;
        }
    }
    long_frames_count_ = now == kLongestFrame && slots_ == IbusSlots::nibbles;
    return true;
}

/// No more bytes will come for those that wait: an incomplete frame is none.
bool IbusDecoder::silence(DecodedFrame& frame) {
    std::span<const std::uint8_t> nothing;
    for (std::size_t start = 0; buffer_.size() != 0; start = 1) {
        if (search(nothing, start, Instant{}, frame)) {
            return true;
        }
    }
    return false;
}

void IbusDecoder::reset() {
    skipped_bytes_ += buffer_.size();
    buffer_.open({});
    buffer_.drop(buffer_.size());
    buffer_.close();
    usual_length_ = 0;
    other_length_ = 0;
    long_frames_count_ = slots_ == IbusSlots::nibbles;
}

void IbusDecoder::damaged_byte() {
    constexpr bool kDecides = false;
    buffer_.append_damaged(kDecides);
    ++rejected_[kDamaged].count;
}

/// Checks the bytes from `position` on and before `end`; `damage` marks the first bytes. Moves
/// `position` to what it found and returns it: a frame, an incomplete frame, or noise if nothing is
/// left.
inline IbusDecoder::Candidate IbusDecoder::find_frame(std::span<const std::uint8_t> bytes,
                                                      std::size_t end, std::uint64_t damage,
                                                      std::size_t& position) {
    // Waiting for the end of an i-BUS2 frame may take longer than the next i.Bus frame needs, so it
    // is searched only on a line that has not shown i.Bus yet: a line carries one of the two.
    const std::uint8_t looked_for =
        usual_length_ != 0 ? kServo | kIa6 : kServo | kIa6 | kIbus2Channels;
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
            if (found.kind == Kind::ibus2) {
                ++rejected_[kIbus2].count;
            } else if (length_counts(found.length)) {
                break;
            }
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
    // The usual case, a whole frame in one read. The general path below gives the same result.
    if (buffer_.size() == 0 && bytes.size() >= kLongestFrame) {
        const auto wire = bytes.first<kLongestFrame>();
        if (word_at(wire, 0) == kLongFrameHeader && long_frame_holds(wire) && long_frames_count_) {
            read_long_frame(wire, received, frame);
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

/// Handles the bytes of a long frame that decide something: the first two and the last. This
/// function and those below are not inline, so that the usual case saves no registers.
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
        const bool holds = long_frame_holds(wire);
        if (holds && long_frames_count_) {
            read_long_frame(wire, received, frame);
            buffer_.pass_kept();
            return {1, true};
        }
        return search_last(holds, received, frame);
    }
    return buffer_.size() == 0 ? decode_pieces(bytes, received, frame)
                               : search_kept(bytes, received, frame);
}

/// Removes bytes at which no frame can begin.
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
    const bool holds = long_frame_holds(wire);
    if (!holds || !long_frames_count_) {
        return search_instead(holds, bytes, received, frame);
    }
    read_long_frame(wire, received, frame);
    buffer_.pass(kLongestFrame, bytes);
    return true;
}

/// The frame was complete with the only byte of this read, but is not accepted as it is.
[[gnu::noinline]] IbusDecoder::Taken IbusDecoder::search_last(bool holds, Instant received,
                                                              DecodedFrame& frame) {
    std::span<const std::uint8_t> nothing_more;
    return {1, search_instead(holds, nothing_more, received, frame)};
}

[[gnu::noinline]] IbusDecoder::Taken IbusDecoder::search_kept(std::span<const std::uint8_t> bytes,
                                                              Instant received,
                                                              DecodedFrame& frame) {
    auto rest = bytes;
    const bool found = search(rest, 0, received, frame);
    return {bytes.size() - rest.size(), found};
}

/// The long frame at the front has a wrong checksum, or its length is not accepted yet.
[[gnu::noinline]] bool IbusDecoder::search_instead(bool holds, std::span<const std::uint8_t>& bytes,
                                                   Instant received, DecodedFrame& frame) {
    rejected_[kChecksum].count += holds ? 0U : 1U;
    return search(bytes, holds ? 0 : 1, received, frame);
}

/// Checks everything from `start` on, which is 0 or 1 behind the front.
bool IbusDecoder::search(std::span<const std::uint8_t>& bytes, std::size_t start, Instant received,
                         DecodedFrame& frame) {
    const std::size_t kept = buffer_.size();
    assert(kept < DamageMarks::kWordBits);
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
