#include <algorithm>
#include <cstring>

#include "transports/codecs/sbus/sbus.h"
#include "transports/codecs/sbus/wire.h"

namespace tribus {

using namespace sbus_wire;

inline bool SbusDecoder::well_formed(std::size_t start) const {
    return well_formed_wire(buffer_.view(start, kSbusFrameLength).first<kSbusFrameLength>()) &&
           !buffer_.damaged(start, kSbusFrameLength);
}

/// Whether all undamaged bytes agree that a frame stands at `start`, so that the next one follows
/// in its place. Where a slot is possible too, a damaged header proves nothing.
bool SbusDecoder::only_damaged(std::size_t start) const {
    const auto fits = [&](std::size_t offset, bool right) {
        return buffer_.damaged(start + offset) || right;
    };
    return buffer_.damaged(start, kSbusFrameLength) &&
           !(slots_left_ > 0 && buffer_.damaged(start)) && fits(0, buffer_[start] == kHeader) &&
           fits(kFlagsAt, flags_allowed(buffer_[start + kFlagsAt])) &&
           fits(kFooterAt, footer_allowed(buffer_[start + kFooterAt]));
}

/// A receiver sends slots always or never. If the frame before had none, a footer that announces
/// them may be a byte of the payload that added bytes moved there.
inline bool SbusDecoder::footer_expected(std::uint8_t footer) const {
    return !slots_follow(footer) || (footer_allowed(footer) && slots_follow(latest()[kFooterAt]));
}

bool SbusDecoder::frame_in_front() const {
    return well_formed(0) && footer_expected(buffer_[kFooterAt]);
}

std::size_t SbusDecoder::after_slots(std::size_t start) const {
    std::size_t position = start;
    while (position < buffer_.size() && position < start + kSlotsLength &&
           is_slot_id(buffer_[position]) && !buffer_.damaged(position)) {
        position += kSlotLength;
    }
    return position;
}

inline SbusDecoder::Judgement SbusDecoder::judge(std::size_t start) const {
    const std::size_t size = buffer_.size();
    const auto no_header = [&](std::size_t position) {
        return position < size && (buffer_[position] != kHeader || buffer_.damaged(position));
    };
    const auto wanted = [&](std::size_t frame) {
        return frame < size ? frame + kSbusFrameLength : frame + 1;
    };
    if (no_header(start)) {
        return {Verdict::no};
    }
    if (size < start + kSbusFrameLength) {
        return {Verdict::undecided, wanted(start)};
    }
    if (!well_formed(start)) {
        return {Verdict::no};
    }
    std::size_t behind = start + kSbusFrameLength;
    if (slots_follow(buffer_[start + kFooterAt])) {
        behind = after_slots(behind);
    }
    if (no_header(behind)) {
        return {Verdict::no};
    }
    if (size < behind + kSbusFrameLength) {
        return {Verdict::undecided, wanted(behind)};
    }
    return {well_formed(behind) ? Verdict::yes : Verdict::no};
}

SbusDecoder::Judgement SbusDecoder::judge_front() const {
    return judge(0);
}

void SbusDecoder::skip(std::size_t count) {
    buffer_.drop(count);
    skipped_bytes_ += count;
}

inline SbusDecoder::Step SbusDecoder::step_unlocked() {
    const Judgement here = judge(0);
    switch (here.verdict) {
        case Verdict::no:
            skip(1);
            return Step::again;
        case Verdict::undecided:
            return buffer_.see(here.wanted) ? Step::again : Step::wait;
        case Verdict::yes:
            break;
    }
    lock_onto(0);
    return Step::frame;
}

inline SbusDecoder::Step SbusDecoder::step_locked() {
    if (slots_left_ > 0 && is_slot_id(buffer_[0]) && !buffer_.damaged(0)) {
        if (!buffer_.see(kSlotLength)) {
            return Step::wait;
        }
        buffer_.drop(kSlotLength);
        --slots_left_;
        return Step::again;
    }
    const bool may_be_frame = buffer_[0] == kHeader || buffer_.damaged(0);
    if (may_be_frame && !buffer_.see(kSbusFrameLength)) {
        return Step::wait;
    }
    if (may_be_frame && well_formed(0)) {
        const Judgement here =
            footer_expected(buffer_[kFooterAt]) ? Judgement{Verdict::yes} : judge(0);
        if (here.verdict == Verdict::undecided) {
            return buffer_.see(here.wanted) ? Step::again : Step::wait;
        }
        if (here.verdict == Verdict::yes) {
            return state_ == State::expecting ? step_expecting() : Step::frame;
        }
    }
    if (may_be_frame && only_damaged(0)) {
        skip(kSbusFrameLength);
        // Its footer may be damaged, so slots may follow: they are passed over.
        slots_left_ = kSlotsPerFrame;
    } else {
        stray_bytes_ = !may_be_frame;
        rejected_[kFraming].count += may_be_frame ? 1U : 0U;
        state_ = State::recovering;
        search_ = {};
    }
    return Step::again;
}

SbusDecoder::Step SbusDecoder::step_recovering() {
    if (slots_follow(latest()[kFooterAt]) || slots_follow(trusted()[kFooterAt])) {
        return step_recovering_among_slots();
    }
    constexpr std::size_t kOneByteMoreOrLess = 3;
    std::optional<std::size_t> wanted;
    for (const std::size_t end : std::span(kEnds).first<kOneByteMoreOrLess>()) {
        const std::size_t start = after_slots(end);
        const Judgement there = judge(start);
        if (there.verdict == Verdict::yes) {
            lock_onto(start);
            return Step::frame;
        }
        if (there.verdict == Verdict::undecided) {
            wanted = std::min(wanted.value_or(there.wanted), there.wanted);
        }
    }
    if (wanted) {
        return buffer_.see(*wanted) ? Step::again : Step::wait;
    }
    give_up_recovering();
    return Step::again;
}

/// Among slots, the fault may also have hit a slot or the frame before it, so the next frame may be
/// anywhere. With moving sticks, a payload hardly looks like a frame twice. With sticks at rest,
/// the true frame is the one most like the last.
SbusDecoder::Step SbusDecoder::step_recovering_among_slots() {
    constexpr int kSticksStandStill = 20;
    for (; search_.judged < kEnds.size(); ++search_.judged) {
        const std::size_t start = after_slots(kEnds[search_.judged]);
        const Judgement there = judge(start);
        if (there.verdict == Verdict::undecided) {
            return buffer_.see(there.wanted) ? Step::again : Step::wait;
        }
        if (there.verdict == Verdict::no) {
            continue;
        }
        const int now = likeness(start);
        if (!search_.found || (now >= kSticksStandStill && now > search_.found_likeness)) {
            search_.found = start;
            search_.found_likeness = now;
        }
    }
    if (search_.found) {
        lock_onto(*search_.found);
        return Step::frame;
    }
    give_up_recovering();
    return Step::again;
}

void SbusDecoder::end_recovering(State next) {
    rejected_[kFraming].count += stray_bytes_ && state_ == State::recovering ? 1U : 0U;
    stray_bytes_ = stray_bytes_ && next != State::locked;
    state_ = next;
}

void SbusDecoder::give_up_recovering() {
    skip(1);
    end_recovering(State::unlocked);
}

/// Locks onto the frame at `start`, which has another frame after it.
void SbusDecoder::lock_onto(std::size_t start) {
    skip(start);
    std::ranges::copy(buffer_.view(0, kSbusFrameLength), frames_[latest_].wire.begin());
    length_shown_ = true;
    end_recovering(State::locked);
}

inline void SbusDecoder::read_frame(Wire wire, Instant received, DecodedFrame& frame) {
    slots_left_ = slots_follow(wire[kFooterAt]) ? kSlotsPerFrame : 0;
    latest_ ^= 1U;
    std::memcpy(frames_[latest_].wire.data(), wire.data(), wire.size());

    frame.channels = kByFlags[wire[kFlagsAt]];
    frame.channels.received = received;
    frame.first_byte = buffer_.first_position();
    frame.length = kSbusFrameLength;
    if (scale_.whole_steps()) {
        scale_.decode_whole(unpack(wire), frame.channels);
    } else {
        scale_each(frame.channels);
    }
}

inline SbusDecoder::Step SbusDecoder::step() {
    if (!buffer_.see(1)) {
        return Step::wait;
    }
    switch (state_) {
        case State::unlocked:
            return step_unlocked();
        case State::expecting:
        case State::locked:
            return step_locked();
        case State::recovering:
            break;
    }
    return step_recovering();
}

SbusDecoder::Taken SbusDecoder::decode(std::span<const std::uint8_t> bytes, Instant received,
                                       DecodedFrame& frame) {
    // The usual case, a whole frame in one read. The general path below gives the same result.
    if (state_ == State::locked && buffer_.size() == 0 && bytes.size() >= kSbusFrameLength &&
        bytes[0] == kHeader && flags_and_footer_plain(bytes.first<kSbusFrameLength>())) {
        read_frame(bytes.first<kSbusFrameLength>(), received, frame);
        buffer_.pass(kSbusFrameLength);
        return {kSbusFrameLength, true};
    }
    if (state_ == State::unlocked) {
        if (bytes.size() == 1 && buffer_.size() == 0 && bytes[0] != kHeader) {
            buffer_.pass(1);
            ++skipped_bytes_;
            return {1, false};
        }
        if (bytes.size() == 1 && buffer_.size() == kFooterAt && !buffer_.any_damaged() &&
            !(flags_allowed(buffer_.kept()[kFlagsAt]) && footer_allowed(bytes[0]))) {
            return refuse_kept(bytes[0]);
        }
        return decode_unlocked(bytes, received, frame);
    }
    if (state_ == State::locked && bytes.size() == 1 && !buffer_.any_damaged()) {
        return decode_byte(bytes, received, frame);
    }
    return decode_pieces(bytes, received, frame);
}

/// Handles the bytes of a locked frame that decide something: the first and the last.
SbusDecoder::Taken SbusDecoder::decode_byte(std::span<const std::uint8_t> bytes, Instant received,
                                            DecodedFrame& frame) {
    const std::uint8_t byte = bytes[0];
    if (buffer_.size() == 0 && byte == kHeader) {
        buffer_.keep_one(byte, kSbusFrameLength - 1);
        return {1, false};
    }
    const Wire wire(buffer_.kept(), kSbusFrameLength);
    if (buffer_.size() == kFooterAt && wire[0] == kHeader && flags_allowed(wire[kFlagsAt]) &&
        !slots_follow(byte)) {
        buffer_.keep_one(byte, 0);
        read_frame(wire, received, frame);
        buffer_.pass_kept();
        return {1, true};
    }
    return decode_pieces(bytes, received, frame);
}

/// Passes over bytes at which no frame can begin: bytes that are no header, and headers without
/// flags and footer in their places.
SbusDecoder::Taken SbusDecoder::decode_unlocked(std::span<const std::uint8_t> bytes,
                                                Instant received, DecodedFrame& frame) {
    auto rest = bytes;
    if (const std::size_t kept = buffer_.size(); kept != 0) {
        const auto joined = buffer_.join(bytes, kSbusFrameLength - 1);
        const std::size_t noise = buffer_.any_damaged() ? noise_in(joined, kept, buffer_.damage())
                                                        : noise_in(joined, kept);
        if (noise < kept && joined.size() - noise < kSbusFrameLength) {
            skipped_bytes_ += noise;
            buffer_.hold(joined.subspan(noise), noise, kSbusFrameLength);
            return {bytes.size(), false};
        }
        pass_noise(noise, rest);
        if (noise < kept) {
            return decode_header(bytes, rest, received, frame);
        }
        if (rest.empty()) {
            return {bytes.size(), false};
        }
    }
    pass_noise(noise_in(rest, rest.size()), rest);
    return rest.empty() ? Taken{bytes.size(), false} : decode_header(bytes, rest, received, frame);
}

/// The last byte shows that the bytes after a header are no frame.
SbusDecoder::Taken SbusDecoder::refuse_kept(std::uint8_t last) {
    buffer_.keep_one(last, 0);
    const std::uint8_t* const kept = buffer_.kept();
    std::size_t noise = 1;
    while (noise < kSbusFrameLength && kept[noise] != kHeader) {
        ++noise;
    }
    skipped_bytes_ += noise;
    if (noise == kSbusFrameLength) {
        buffer_.pass_kept();
    } else {
        buffer_.hold({kept + noise, kSbusFrameLength - noise}, noise, kSbusFrameLength);
    }
    return {1, false};
}

inline void SbusDecoder::pass_noise(std::size_t noise, std::span<const std::uint8_t>& bytes) {
    buffer_.pass(noise, bytes);
    skipped_bytes_ += noise;
}

/// The byte at the front is a header, which may begin a frame.
inline SbusDecoder::Taken SbusDecoder::decode_header(std::span<const std::uint8_t> bytes,
                                                     std::span<const std::uint8_t> rest,
                                                     Instant received, DecodedFrame& frame) {
    if (!buffer_.reaches(kSbusFrameLength, rest)) {
        return {bytes.size(), false};
    }
    const bool found = decode_in_steps(rest, received, frame);
    return {bytes.size() - rest.size(), found};
}

[[gnu::noinline]] SbusDecoder::Taken SbusDecoder::decode_pieces(std::span<const std::uint8_t> bytes,
                                                                Instant received,
                                                                DecodedFrame& frame) {
    auto rest = bytes;
    const bool found =
        state_ == State::locked && !buffer_.any_damaged() && buffer_.peek(0, rest) == kHeader
            ? decode_locked(rest, received, frame)
            : decode_in_steps(rest, received, frame);
    return {bytes.size() - rest.size(), found};
}

/// A frame in its place, in several reads.
inline bool SbusDecoder::decode_locked(std::span<const std::uint8_t>& bytes, Instant received,
                                       DecodedFrame& frame) {
    if (!buffer_.reaches(kSbusFrameLength, bytes)) {
        return false;
    }
    const Wire wire(buffer_.whole(kSbusFrameLength, bytes), kSbusFrameLength);
    if (!well_formed_wire(wire) || !footer_expected(wire[kFooterAt])) {
        return decode_in_steps(bytes, received, frame);
    }
    read_frame(wire, received, frame);
    buffer_.pass(kSbusFrameLength, bytes);
    return true;
}

bool SbusDecoder::decode_in_steps(std::span<const std::uint8_t>& bytes, Instant received,
                                  DecodedFrame& frame) {
    buffer_.open(bytes);
    Step stepped = Step::again;
    while (stepped == Step::again) {
        stepped = step();
    }
    if (stepped == Step::frame) {
        take_front(received, frame);
    }
    bytes = buffer_.close();
    return stepped == Step::frame;
}

void SbusDecoder::take_front(Instant received, DecodedFrame& frame) {
    read_frame(front(), received, frame);
    buffer_.drop(kSbusFrameLength);
}

/// Whether a frame stands at `start` and only lacks the bytes after it.
bool SbusDecoder::last_frame_at(std::size_t start) const {
    return start + kSbusFrameLength <= buffer_.size() && judge(start).verdict == Verdict::undecided;
}

}  // namespace tribus
