#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/cli/protocol_use.h"
#include "app/wire/frames/frame_judge.h"
#include "core/time.h"
#include "transports/codecs/codec.h"
#include "transports/recordings/recording_source.h"

namespace tribus {

/// Position of the first byte of a frame in a recording.
struct FramePlace {
    std::size_t burst = 0;
    std::size_t byte = 0;
    auto operator<=>(const FramePlace&) const = default;
};

struct FoundFrame {
    const Protocol* protocol = nullptr;
    DecodedFrame frame;
    FramePlace place;
    std::size_t last_burst = 0;  ///< in which it ends
    /// Start of its first byte, empty if the recording has no times; on CAN the arrival of the CAN
    /// frame that completed the snapshot.
    std::optional<Duration> start;
    /// Valid only during the call.
    std::span<const FrameDetail> details;
    /// Result of the input's loss detection, if the frames are decoded with an input's settings.
    std::optional<JudgedFrame> judged{};
};
using FrameHandler = std::function<void(const FoundFrame&)>;

/// Counters of the CAN frames of a log.
struct CanTally {
    std::uint64_t frames = 0;
    std::uint64_t others = 0;  ///< of these, frames with ids that the protocol does not use
    LogFacts log{};
};

/// Counters of a decoder.
struct Tally {
    std::uint64_t bytes = 0;   ///< on CAN, bytes of data
    std::uint64_t frames = 0;  ///< on CAN, snapshots of the channels
    std::vector<NamedCount> rejected;
    std::uint64_t skipped_bytes = 0;
    /// What was wrong with the first frame of which the decoder can tell it (write_fault).
    std::string first_fault{};
    std::optional<CanTally> can{};
};

/// Runs the decoder of one protocol over a recording and reports each frame with its place and
/// start. Thread-bound.
///
/// `index` of a burst may skip some. A frame may start in one burst and end in a later one. If the
/// bursts have times, pauses between them separate frames as on a live line. CAN protocols ignore
/// bursts, serial protocols CAN frames.
class FrameFinder : public RecordingTaker {
  public:
    /// The first byte of which a frame may still come; nothing if none waits.
    virtual std::optional<FramePlace> waits_since() const { return std::nullopt; }
    /// Call it at the end of the recording.
    virtual void finish() {}
    /// Without the facts of the log.
    virtual Tally tally() const = 0;
};

std::unique_ptr<FrameFinder> make_frame_finder(const ProtocolUse& use, FrameHandler handler);

/// Runs a finder over a whole recording. Returns its counters, on CAN with the facts of the log.
Tally find_frames(const ProtocolUse& use, RecordingSource& recording, FrameHandler handler);

}  // namespace tribus
