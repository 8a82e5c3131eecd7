#include "pipelines/engine/read_pacer.h"

#include <algorithm>

namespace tribus {

/// A paced frame does not show how the port delivers. A change of length restarts the count.
void ReadPacer::frame_ended() {
    const bool same_length = bytes_ == frame_length_;
    if (!same_length || (!paced_ && deliveries_ < kManyDeliveries)) {
        frames_in_pieces_ = 0;
    } else if (!paced_) {
        frames_in_pieces_ = std::min(frames_in_pieces_ + 1, kFramesToConfirm);
    }
    frame_length_ = bytes_;
    bytes_ = 0;
    deliveries_ = 0;
    paced_ = false;
}

Instant ReadPacer::delivered(std::size_t bytes, bool frame_came, Instant now) {
    const bool begins = bytes_ == 0 && now - latest_ >= kPauseBytes * byte_time_;
    latest_ = now;
    bytes_ += bytes;
    ++deliveries_;
    if (frame_came) {
        frame_ended();
        return now;
    }
    // Several bytes at once: the port has a FIFO, or the thread was delayed.
    const bool single = bytes <= kEarlyBytes;
    if (!begins || !single || !in_pieces() || bytes_ + kEarlyBytes >= frame_length_) {
        return now;
    }
    paced_ = true;
    return now + static_cast<int>(frame_length_ - bytes_ - kEarlyBytes) * byte_time_;
}

}  // namespace tribus
