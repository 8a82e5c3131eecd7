#include "transports/codecs/line_pauses.h"

namespace tribus {

/// Whether a gap of this length is a pause.
bool LinePauses::judge(Duration pause, std::uint64_t position, std::size_t waiting) {
    if (pause <= kSlowestPort && pause <= holds_back_ + holds_back_ / 4) {
        within_ = pause;
        within_position_ = position;
        return false;
    }
    cut_off_ = was_wrong_cut(position, waiting) ? 0 : waiting;
    cut_ = pause;
    cut_position_ = position;
    return true;
}

/// Counts a wrong cut if the bytes that the previous pause cut off are whole frames only together
/// with the bytes since then: that gap was no pause of the line. The bytes that wait now may be
/// left over. Returns whether there are whole frames without a rest.
bool LinePauses::was_wrong_cut(std::uint64_t position, std::size_t waiting) {
    if (cut_off_ == 0 || frame_length_ == 0 || cut_off_ % frame_length_ == 0) {
        return false;
    }
    const std::uint64_t together = cut_off_ + position - cut_position_;
    const bool whole = together % frame_length_ == 0;
    if (!whole && (together - waiting) % frame_length_ != 0) {
        wrong_cuts_ = 0;
        return false;
    }
    ++wrong_cuts_;
    if (wrong_cuts_ >= kWrongCutsNeeded && cut_ <= kSlowestPort) {
        holds_back_ = std::max(holds_back_, cut_);
    }
    return whole;
}

}  // namespace tribus
