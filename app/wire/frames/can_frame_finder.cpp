#include "app/wire/frames/can_frame_finder.h"

#include <algorithm>
#include <utility>

namespace tribus {

CanFrameFinder::CanFrameFinder(const ProtocolUse& use, FrameHandler handler)
    : protocol_(use.protocol),
      handler_(std::move(handler)),
      decoder_(make_can_decoder(*use.protocol, use.settings)),
      judge_(use.supervision) {}

void CanFrameFinder::feed(const RecordedCanFrame& recorded) {
    const CanFrame& frame = recorded.frame;
    ++tally_.can_frames;
    tally_.bytes += frame.remote ? 0 : frame.length;
    const bool wanted = std::ranges::any_of(
        decoder_->wanted(), [&](const CanIdMatch& match) { return match.matches(frame); });
    if (!wanted) {
        ++tally_.other_can_frames;
        return;
    }
    judge_.bytes_came(recorded.at);
    const auto snapshot = decoder_->next(frame, Instant(recorded.at));
    if (!snapshot) {
        return;
    }
    ++tally_.frames;
    handler_({.protocol = protocol_,
              .frame = {.channels = *snapshot, .first_byte = 0, .length = 0},
              .place = {},
              .start = recorded.at,
              .details = decoder_->details(),
              .judged = judge_.judge(*snapshot, recorded.at)});
}

CanTally CanFrameFinder::tally() const {
    CanTally tally = tally_;
    const auto rejected = decoder_->rejected();
    tally.rejected.assign(rejected.begin(), rejected.end());
    return tally;
}

}  // namespace tribus
