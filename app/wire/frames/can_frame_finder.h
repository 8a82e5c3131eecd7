#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "app/cli/protocol_use.h"
#include "app/wire/frames/frame_finder.h"
#include "core/time.h"
#include "transports/codecs/can_codec.h"
#include "transports/recordings/recording.h"

namespace tribus {

/// Counters of a CAN decoder.
struct CanTally {
    std::uint64_t bytes = 0;  ///< of data
    std::uint64_t can_frames = 0;
    std::uint64_t other_can_frames =
        0;                     ///< of these, frames with ids that the protocol does not use
    std::uint64_t frames = 0;  ///< channel snapshots
    std::vector<NamedCount> rejected;
    /// From the log itself, see Recording.
    std::uint64_t error_frames = 0;
    Duration log_start{};
};

/// Runs the decoder of one CAN protocol over the frames of a log. The start of a snapshot is the
/// arrival of the CAN frame that completed it.
class CanFrameFinder {
  public:
    CanFrameFinder(const ProtocolUse& use, FrameHandler handler);

    /// Feeds a frame, in the order of the log.
    void feed(const RecordedCanFrame& frame);
    CanTally tally() const;

  private:
    const Protocol* protocol_;
    FrameHandler handler_;
    std::unique_ptr<CanDecoder> decoder_;
    FrameJudge judge_;
    CanTally tally_;
};

}  // namespace tribus
