#include <algorithm>
#include <optional>
#include <span>

#include "transports/codecs/sbus/sbus.h"
#include "transports/codecs/sbus/wire.h"

/// What the SBUS decoder does when the line pauses or is unplugged, or a recording ends.
namespace tribus {

using namespace sbus_wire;

/// A pause proves a frame as well as a second frame does, if no bytes before the frame may belong
/// to it.
bool SbusDecoder::silence(DecodedFrame& frame) {
    buffer_.open({});
    const std::size_t size = buffer_.size();
    const bool alone =
        stray_bytes_ || (buffer_.first_position() == start_position_ && size == kSbusFrameLength);
    // A frame that waits for its proof; its slots may come after the pause.
    const bool in_place = state_ == State::locked && size == kSbusFrameLength && last_frame_at(0);
    const bool whole = in_place || (state_ != State::locked && alone && size >= kSbusFrameLength &&
                                    last_frame_at(size - kSbusFrameLength));
    if (whole) {
        lock_onto(size - kSbusFrameLength);
        take_front(Instant{}, frame);
    } else {
        const bool frame_began = size != 0 && (buffer_[0] == kHeader || buffer_.damaged(0));
        rejected_[kFraming].count += state_ == State::locked && frame_began ? 1U : 0U;
        skip(size);
        state_ = State::locked;
        stray_bytes_ = false;
    }
    buffer_.close();
    return whole;
}

void SbusDecoder::reset() {
    buffer_.open({});
    skip(buffer_.size());
    buffer_.close();
    state_ = State::unlocked;
    stray_bytes_ = false;
    slots_left_ = 0;
    start_position_ = buffer_.first_position();
}

std::optional<DecodedFrame> SbusDecoder::finish() {
    buffer_.open({});
    std::size_t start = 0;
    if (state_ == State::recovering) {
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
