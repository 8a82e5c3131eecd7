#include <cstddef>
#include <cstdint>

#include "transports/codecs/dsm/dsm.h"

/// When a row of agreeing frames ends, and when a pause shows that it goes on.
namespace tribus {

/// Frames count again only after others have agreed; older values do not count any more.
void DsmDecoder::break_row() {
    if (agreeing_ >= kAgreeingFrames) {
        broken_row_ = Row{.channels = channels_in_row_};
        for (std::size_t i = 0; i < known_.size(); ++i) {
            broken_row_->layouts |= known_[i].counts ? 1U << i : 0U;
        }
    }
    agreeing_ = 0;
    channels_in_row_ = 0;
    usual_until_ = kNever;
    for (Known& known : known_) {
        known.counts = false;
    }
}

void DsmDecoder::forget() {
    break_row();
    known_ = {};
    broken_row_.reset();
    needs_pause_ = false;
}

/// All bytes before this pause are dropped. Frames that came without a pause are whole, so that
/// another number of bytes shows that the line lost or added some: the pause tells the place anew.
void DsmDecoder::resume_row() {
    const std::uint64_t burst = buffer_.first_position() - burst_begin_;
    if (burst % kDsmFrameBytes != 0 && broken_row_ && agreeing_ < kAgreeingFrames) {
        agreeing_ = kAgreeingFrames;
        channels_in_row_ = broken_row_->channels;
        for (std::size_t i = 0; i < known_.size(); ++i) {
            known_[i].counts = (broken_row_->layouts >> i & 1U) != 0;
        }
        needs_pause_ = true;
    }
    if (burst != 0) {
        broken_row_.reset();
    }
}

void DsmDecoder::damaged_byte() {
    buffer_.append_damaged();
    ++rejected_[kDamaged].count;
}

void DsmDecoder::reset() {
    buffer_.open({});
    skip(buffer_.size());
    burst_begin_ = buffer_.first_position();
    buffer_.close();
    forget();
    aligned_ = false;
}

}  // namespace tribus
