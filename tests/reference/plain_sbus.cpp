#include "tests/reference/plain_sbus.h"

#include <algorithm>
#include <functional>
#include <numeric>

#include "tests/reference/plain_sbus_wire.h"

namespace tribus::reference {

using namespace plain_sbus_wire;

namespace {

constexpr std::uint8_t kFlagsUnused = 0xF0;

bool flags_allowed(std::uint8_t flags) {
    return (flags & kFlagsUnused) == 0;
}

/// 0x00 is SBUS, x4 is SBUS2, 0x08 is FASSTest 12CH. Slots follow the last two
/// (docs/protocols/sbus.md, "Footer and SBUS2").
bool footer_allowed(std::uint8_t footer) {
    const unsigned low = footer & 0x0FU;
    return low == 0x0 || low == 0x4 || low == 0x8;
}
bool slots_follow(std::uint8_t footer) {
    return (footer & 0x0FU) != 0;
}

/// The 32 slot ids: a five-bit number, then 011 (docs/protocols/sbus.md, "Footer and SBUS2").
bool is_slot_id(std::uint8_t byte) {
    return (byte & 0x07U) == 0x03;
}

}  // namespace

bool PlainSbusDecoder::well_formed(std::size_t start) const {
    return buffer_[start] == kHeader && flags_allowed(buffer_[start + kFlagsAt]) &&
           footer_allowed(buffer_[start + kFooterAt]) && !buffer_.damaged(start, kSbusFrameLength);
}

/// Returns whether every undamaged byte agrees with a frame at `start`, so that the next frame
/// follows in its place. Where a slot may be instead, a frame with a damaged header proves nothing.
bool PlainSbusDecoder::only_damaged(std::size_t start) const {
    const auto fits = [&](std::size_t offset, bool right) {
        return buffer_.damaged(start + offset) || right;
    };
    return buffer_.damaged(start, kSbusFrameLength) &&
           !(slots_left_ > 0 && buffer_.damaged(start)) && fits(0, buffer_[start] == kHeader) &&
           fits(kFlagsAt, flags_allowed(buffer_[start + kFlagsAt])) &&
           fits(kFooterAt, footer_allowed(buffer_[start + kFooterAt]));
}

std::size_t PlainSbusDecoder::after_slots(std::size_t start) const {
    std::size_t position = start;
    while (position < buffer_.size() && position < start + kSlotsLength &&
           is_slot_id(buffer_[position]) && !buffer_.damaged(position)) {
        position += kSlotLength;
    }
    return position;
}

PlainSbusDecoder::Verdict PlainSbusDecoder::judge(std::size_t start) const {
    const std::size_t size = buffer_.size();
    if (start < size && (buffer_[start] != kHeader || buffer_.damaged(start))) {
        return Verdict::no;
    }
    if (size < start + kSbusFrameLength) {
        return Verdict::undecided;
    }
    if (!well_formed(start)) {
        return Verdict::no;
    }
    std::size_t behind = start + kSbusFrameLength;
    if (slots_follow(buffer_[start + kFooterAt])) {
        behind = after_slots(behind);
    }
    if (behind < size && (buffer_[behind] != kHeader || buffer_.damaged(behind))) {
        return Verdict::no;
    }
    if (size < behind + kSbusFrameLength) {
        return Verdict::undecided;
    }
    return well_formed(behind) ? Verdict::yes : Verdict::no;
}

void PlainSbusDecoder::skip(std::size_t count) {
    buffer_.drop(count);
    skipped_bytes_ += count;
}

/// Whether the first 36 bytes are a frame of 24 channels.
bool PlainSbusDecoder::is_wide() const {
    return buffer_[0] == kHeader && flags_allowed(buffer_[34]) && buffer_[35] == 0;
}

/// Whether the bytes since the latest pause are as many as some of them have, and end like one.
bool PlainSbusDecoder::wide_burst() const {
    const std::size_t size = buffer_.size();
    const std::uint64_t burst = buffer_.first_position() + size - burst_begin_;
    return burst != 0 && burst <= 4 * 36 && burst % 36 == 0 && size >= 2 &&
           flags_allowed(buffer_[size - 2]) && buffer_[size - 1] == 0;
}

bool PlainSbusDecoder::step_unlocked() {
    switch (judge(0)) {
        case Verdict::no:
            skip(1);
            return true;
        case Verdict::undecided:
            return false;
        case Verdict::yes:
            lock_onto(0);
            break;
    }
    return true;
}

bool PlainSbusDecoder::step_locked() {
    if (slots_left_ > 0 && is_slot_id(buffer_[0]) && !buffer_.damaged(0)) {
        if (buffer_.size() < kSlotLength) {
            return false;
        }
        buffer_.drop(kSlotLength);
        --slots_left_;
        return true;
    }
    const bool may_be_frame = buffer_[0] == kHeader || buffer_.damaged(0);
    if (may_be_frame && buffer_.size() < kSbusFrameLength) {
        return false;
    }
    // A receiver sends slots always or never, so a footer that newly announces them needs proof.
    const bool slots_begin = may_be_frame && well_formed(0) && slots_follow(buffer_[kFooterAt]) &&
                             !slots_follow(latest_[kFooterAt]);
    if (slots_begin && judge(0) == Verdict::undecided) {
        return false;
    }
    if (may_be_frame && well_formed(0) && (!slots_begin || judge(0) == Verdict::yes)) {
        if (state_ == State::expecting && buffer_.size() < 37) {
            return false;
        }
        if (state_ == State::expecting && is_wide()) {
            skip(36);
            return true;
        }
        if (state_ == State::expecting && judge(0) == Verdict::undecided) {
            return false;
        }
        if (state_ == State::expecting && judge(0) == Verdict::no) {
            skip(1);
            state_ = State::unlocked;
            return true;
        }
        length_shown_ = true;
        state_ = State::locked;
        frame_ready_ = true;
    } else if (may_be_frame && only_damaged(0)) {
        skip(kSbusFrameLength);
        // The footer may be damaged, so it is unknown whether slots follow: they are allowed.
        slots_left_ = kSlotsPerFrame;
    } else {
        if (may_be_frame) {
            ++rejected_[kFraming].count;
        } else {
            stray_bytes_ = true;
        }
        state_ = State::recovering;
    }
    return true;
}

/// Returns how many bytes before the footer are the same in the frame at `start` and in the last
/// frame beyond doubt. The footer cycles in SBUS2.
int PlainSbusDecoder::likeness(std::size_t start) const {
    const auto bytes = buffer_.view(start, kFooterAt);
    return std::inner_product(bytes.begin(), bytes.end(), trusted_.begin(), 0, std::plus<>{},
                              std::equal_to<>{});
}

bool PlainSbusDecoder::step_recovering() {
    // With slots around, the fault may have hit a slot or the frame before it, so the next frame
    // may be anywhere. Sticks that move are unlikely to imitate a frame twice. If the sticks stand
    // still, the true frame is the one most like the last.
    constexpr int kSticksStandStill = 20;
    const bool among_slots = slots_follow(latest_[kFooterAt]) || slots_follow(trusted_[kFooterAt]);
    std::optional<std::size_t> found;
    int found_likeness = 0;
    bool undecided = false;
    constexpr std::size_t kOneByteMoreOrLess = 3;
    for (const std::size_t end :
         std::span(kEnds).first(among_slots ? kEnds.size() : kOneByteMoreOrLess)) {
        const std::size_t start = after_slots(end);
        const Verdict verdict = judge(start);
        undecided = undecided || verdict == Verdict::undecided;
        if (verdict != Verdict::yes) {
            continue;
        }
        const int now = likeness(start);
        if (!found || (now >= kSticksStandStill && now > found_likeness)) {
            found = start;
            found_likeness = now;
        }
        if (!among_slots) {
            break;
        }
    }
    if (undecided && (!found || among_slots)) {
        return false;
    }
    if (found) {
        lock_onto(*found);
    } else {
        skip(1);
        end_recovering(State::unlocked);
    }
    return true;
}

void PlainSbusDecoder::end_recovering(State next) {
    if (stray_bytes_ && state_ == State::recovering) {
        ++rejected_[kFraming].count;
    }
    if (next == State::locked) {
        stray_bytes_ = false;
    }
    state_ = next;
}

/// Locks onto the frame at `start`, which has another frame behind it.
void PlainSbusDecoder::lock_onto(std::size_t start) {
    skip(start);
    std::ranges::copy(buffer_.view(0, kSbusFrameLength), latest_.begin());
    length_shown_ = true;
    end_recovering(State::locked);
    frame_ready_ = true;
}

DecodedFrame PlainSbusDecoder::take_frame(Instant received) {
    const SbusFrame wire =
        plain_parse_sbus(buffer_.view(0, kSbusFrameLength).first<kSbusFrameLength>());
    DecodedFrame frame{.first_byte = buffer_.first_position(), .length = kSbusFrameLength};
    for (std::size_t channel = 0; channel < kSbusChannels; ++channel) {
        frame.channels.set(channel, scale_.decode(wire.raw[channel]));
    }
    frame.channels.set(16, wire.channel_17 ? kSwitchOnPulse : kSwitchOffPulse);
    frame.channels.set(17, wire.channel_18 ? kSwitchOnPulse : kSwitchOffPulse);
    frame.channels.frame_lost = wire.frame_lost;
    frame.channels.failsafe = wire.failsafe;
    frame.channels.received = received;
    frame.channels.origin = Origin::sbus;
    raw_ = wire.raw;
    footer_[0] = wire.footer;
    slots_left_ = slots_follow(wire.footer) ? kSlotsPerFrame : 0;
    // This frame is in its place, so the one before it is beyond doubt.
    trusted_ = latest_;
    std::ranges::copy(buffer_.view(0, kSbusFrameLength), latest_.begin());
    buffer_.drop(kSbusFrameLength);
    frame_ready_ = false;
    return frame;
}

void PlainSbusDecoder::damaged_byte() {
    buffer_.append_damaged();
    ++rejected_[kDamaged].count;
}

std::optional<DecodedFrame> PlainSbusDecoder::next(std::span<const std::uint8_t>& bytes,
                                                   Instant received) {
    while (true) {
        bool stepped = false;
        if (buffer_.size() > 0) {
            switch (state_) {
                case State::unlocked:
                    stepped = step_unlocked();
                    break;
                case State::expecting:
                case State::locked:
                    stepped = step_locked();
                    break;
                case State::recovering:
                    stepped = step_recovering();
                    break;
            }
        }
        if (frame_ready_) {
            return take_frame(received);
        }
        if (!stepped) {
            if (bytes.empty()) {
                return std::nullopt;
            }
            buffer_.take(bytes, 1);
        }
    }
}

/// A pause cuts off the bytes in the buffer. A frame that ends at the pause is proved only if it is
/// all that ever came, if it stands in its place, or if no frame began where one was expected.
std::optional<DecodedFrame> PlainSbusDecoder::silence() {
    const std::size_t size = buffer_.size();
    const std::uint64_t burst = buffer_.first_position() + size - burst_begin_;
    const bool wide = wide_burst();
    // Bytes more than a frame may be the rest of 24 channels, until the line has shown its length.
    const bool possible = length_shown_ || burst == kSbusFrameLength ||
                          (burst == previous_burst_ && burst <= kSbusFrameLength + 3);
    const bool first_of_all =
        buffer_.first_position() == start_position_ && size == kSbusFrameLength;
    const bool in_step = state_ == State::locked || state_ == State::expecting;
    const bool in_place = in_step && size == kSbusFrameLength;
    const bool behind_noise =
        !in_step && !wide && (first_of_all || stray_bytes_) && size >= kSbusFrameLength;
    if (possible && (in_place || behind_noise) && well_formed(size - kSbusFrameLength)) {
        lock_onto(size - kSbusFrameLength);
        return take_frame(Instant{});
    }
    const bool before_noise = state_ == State::expecting && !wide && size > kSbusFrameLength;
    if (possible && before_noise && well_formed(0) &&
        (!slots_follow(buffer_[kFooterAt]) || slots_follow(latest_[kFooterAt]))) {
        lock_onto(0);
        return take_frame(Instant{});
    }
    const bool frame_began = size > 0 && (buffer_[0] == kHeader || buffer_.damaged(0));
    if (in_step && frame_began) {
        ++rejected_[kFraming].count;
    }
    skip(size);
    stray_bytes_ = false;
    length_shown_ = length_shown_ && !wide;
    previous_burst_ = burst == 0 ? previous_burst_ : burst;
    burst_begin_ = buffer_.first_position();
    state_ = length_shown_ ? State::locked : State::expecting;
    return std::nullopt;
}

void PlainSbusDecoder::reset() {
    skip(buffer_.size());
    stray_bytes_ = false;
    slots_left_ = 0;
    length_shown_ = false;
    state_ = State::unlocked;
    start_position_ = buffer_.first_position();
    burst_begin_ = start_position_;
    previous_burst_ = 0;
}

std::optional<DecodedFrame> PlainSbusDecoder::finish() {
    const auto last_frame_at = [this](std::size_t start) {
        return start + kSbusFrameLength <= buffer_.size() && judge(start) == Verdict::undecided;
    };
    std::size_t start = 0;
    if (wide_burst()) {
        return std::nullopt;
    }
    if (state_ == State::recovering) {
        const auto* found = std::ranges::find_if(
            kEnds, [&](std::size_t end) { return last_frame_at(after_slots(end)); });
        start = found == kEnds.end() ? 0 : after_slots(*found);
    }
    while (start < buffer_.size() && !last_frame_at(start)) {
        ++start;
    }
    if (start == buffer_.size()) {
        return std::nullopt;
    }
    skip(start);
    return take_frame(Instant{});
}

}  // namespace tribus::reference
