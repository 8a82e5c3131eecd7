#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "app/frame_finder.h"
#include "app/protocol_use.h"
#include "core/time.h"
#include "transports/codecs/can_codec.h"
#include "transports/links/recording.h"

namespace tribus {

/// What a decoder made of the CAN frames that it was given.
struct CanTally {
    std::uint64_t bytes = 0;  ///< of data
    std::uint64_t can_frames = 0;
    std::uint64_t other_can_frames = 0;  ///< those of them whose ids the protocol does not read
    std::uint64_t frames = 0;            ///< snapshots of the channels
    std::vector<NamedCount> rejected;
    /// Of the log itself, see Recording.
    std::uint64_t error_frames = 0;
    Duration log_start{};
};

/// Runs the decoder of one CAN protocol over the frames of a log. The start of a snapshot is the
/// arrival of the CAN frame that completed it.
class CanFrameFinder {
  public:
    CanFrameFinder(const ProtocolUse& use, FrameHandler handler);

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
