#include <algorithm>
#include <optional>
#include <span>
#include <string_view>

#include "transports/codecs/sbus/sbus.h"
#include "transports/codecs/sbus/sbus24.h"
#include "transports/codecs/sbus/wire.h"

/// What the SBUS decoder does when the line pauses, damages a byte or is unplugged, or a recording
/// ends, and how it tells frames of 24 channels.
namespace tribus {

using namespace sbus_wire;

/// A frame stands at the front, if these are not 24 channels. A second one behind it proves it;
/// without that, only the pause can.
SbusDecoder::Step SbusDecoder::step_expecting() {
    if (!buffer_.see(kSbus24FrameLength + 1)) {
        return Step::wait;
    }
    if (is_sbus24_frame(buffer_.view(0, kSbus24FrameLength).first<kSbus24FrameLength>())) {
        skip(kSbus24FrameLength);
        return Step::again;
    }
    const Judgement here = judge_front();
    if (here.verdict == Verdict::undecided) {
        return buffer_.see(here.wanted) ? Step::again : Step::wait;
    }
    if (here.verdict == Verdict::no) {
        skip(1);
        state_ = State::unlocked;
        return Step::again;
    }
    state_ = State::locked;
    length_shown_ = true;
    return Step::frame;
}

/// Whether a burst of so many bytes may be a frame and stray bytes. Before the line has shown the
/// length of its frames, it may be a frame of 24 channels that lost some: never twice the same
/// number.
bool SbusDecoder::may_be_frame_and_stray_bytes(std::size_t burst) const {
    constexpr std::size_t kMostStrayBytes = 3;
    return length_shown_ || burst == kSbusFrameLength ||
           (burst == previous_burst_ && burst <= kSbusFrameLength + kMostStrayBytes);
}

/// Whether the bytes before this pause are whole frames of 24 channels: one, or some that came at
/// once. As many bytes are never frames of 25.
bool SbusDecoder::wide_burst_ends() const {
    constexpr std::size_t kMostAtOnce = 4;
    const std::size_t size = buffer_.size();
    if (size < 2 || buffer_[size - 1] != 0 || !flags_allowed(buffer_[size - 2])) {
        return false;
    }
    const std::size_t burst = burst_size();
    return burst <= kMostAtOnce * kSbus24FrameLength && burst % kSbus24FrameLength == 0;
}

/// A pause proves a frame as well as a second frame does, if no bytes before the frame may belong
/// to it.
bool SbusDecoder::silence(DecodedFrame& frame) {
    buffer_.open({});
    const std::size_t size = buffer_.size();
    const std::size_t burst = burst_size();
    const bool possible = may_be_frame_and_stray_bytes(burst);
    const bool wide = wide_burst_ends();
    const bool alone =
        stray_bytes_ || (buffer_.first_position() == start_position_ && size == kSbusFrameLength);
    // A frame that waits for its proof; its slots may come after the pause.
    const bool in_place = possible && in_step() && size == kSbusFrameLength && last_frame_at(0);
    // The bytes between it and the pause do not matter, unless they are the rest of 24 channels.
    const bool first = possible && state_ == State::expecting && !wide && size > kSbusFrameLength &&
                       frame_in_front();
    const bool last = possible && !in_step() && !wide && alone && size >= kSbusFrameLength &&
                      last_frame_at(size - kSbusFrameLength);
    const bool whole = in_place || first || last;
    if (whole) {
        lock_onto(last ? size - kSbusFrameLength : 0);
        take_front(Instant{}, frame);
    } else {
        // Behind the frames of a usual line nothing waits.
        if (size != 0) {
            const bool frame_began = buffer_[0] == kHeader || buffer_.damaged(0);
            rejected_[kFraming].count += in_step() && frame_began ? 1U : 0U;
            skip(size);
        }
        length_shown_ = length_shown_ && !wide;
        state_ = length_shown_ ? State::locked : State::expecting;
        stray_bytes_ = false;
        previous_burst_ = burst == 0 ? previous_burst_ : burst;
        burst_begin_ = buffer_.first_position();
    }
    buffer_.close();
    return whole;
}

std::size_t SbusDecoder::write_fault(std::span<char> text) const {
    const bool wide =
        !length_shown_ && previous_burst_ != 0 && previous_burst_ % kSbus24FrameLength == 0;
    const std::string_view told = wide ? kSbus24Text.substr(0, text.size()) : "";
    std::ranges::copy(told, text.begin());
    return told.size();
}

void SbusDecoder::damaged_byte() {
    const bool behind_header =
        state_ == State::unlocked && buffer_.size() != 0 && buffer_.size() < kSbusFrameLength;
    buffer_.append_damaged(!behind_header);
    ++rejected_[kDamaged].count;
}

void SbusDecoder::reset() {
    buffer_.open({});
    skip(buffer_.size());
    buffer_.close();
    state_ = State::unlocked;
    stray_bytes_ = false;
    slots_left_ = 0;
    start_position_ = buffer_.first_position();
    length_shown_ = false;
    burst_begin_ = start_position_;
    previous_burst_ = 0;
}

std::optional<DecodedFrame> SbusDecoder::finish() {
    buffer_.open({});
    std::size_t start = 0;
    if (wide_burst_ends()) {
        start = buffer_.size();
    } else if (state_ == State::recovering) {
        const auto* found = std::ranges::find_if(
            kEnds, [&](std::size_t end) { return last_frame_at(after_slots(end)); });
        start = found == kEnds.end() ? 0 : after_slots(*found);
    }
    while (start < buffer_.size() && !last_frame_at(start)) {
        ++start;
    }
    if (start == buffer_.size()) {
        buffer_.close();
        return std::nullopt;
    }
    skip(start);
    DecodedFrame frame;
    take_front(Instant{}, frame);
    buffer_.close();
    return frame;
}

}  // namespace tribus
