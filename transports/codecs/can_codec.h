#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "core/can_frame.h"
#include "core/channel_frame.h"
#include "core/time.h"
#include "transports/codecs/codec.h"

namespace tribus {

class ValueBoard;

namespace dronecan {
struct Voice;
}  // namespace dronecan

/// CAN frames in, snapshots of the channels out: only whole ones, whose parts belong together.
/// Pure: no descriptor, clock, log or heap after construction. Thread-bound: one thread at a time.
class CanDecoder : public DecoderReport {
  public:
    /// Some of its frames are FD. Constant.
    virtual bool uses_fd() const { return false; }
    /// The ids that it wants to see. Constant.
    virtual std::span<const CanIdMatch> wanted() const = 0;

    /// Takes one frame that arrived at `received`; ids that it does not want are passed over.
    /// Returns the snapshot that the frame completes, if it does. `received` of the snapshot is
    /// when its values were fresh: the arrival, or earlier where the sender tells their age.
    virtual std::optional<ChannelFrame> next(const CanFrame& frame, Instant received) = 0;
};

/// A snapshot of the channels in, CAN frames out. Pure; keeps counters only. Total: every snapshot
/// has an encoding. Thread-bound: one thread at a time.
class CanEncoder {
  public:
    CanEncoder() = default;
    CanEncoder(const CanEncoder&) = delete;
    CanEncoder& operator=(const CanEncoder&) = delete;
    virtual ~CanEncoder() = default;

    /// Some of its frames are FD. Constant.
    virtual bool uses_fd() const { return false; }
    /// The ids that it sends, and nobody else on the bus may. Constant.
    virtual std::span<const CanIdMatch> sent() const = 0;

    /// Where to read the named values that it sends, which are looked up here by their names. For
    /// the start, before the first `encode`; without it, and for names that the board has not,
    /// there is no number. The board outlives the encoder.
    virtual void use(const ValueBoard& /*board*/) {}

    /// The channels that need a value on the wire, a bit each: of the others the format can say
    /// that `snapshot` does not have them, or it does not send them.
    virtual std::uint32_t needed_channels(const ChannelFrame& snapshot) const = 0;
    /// What it sends can say that a snapshot is marked frame-lost. Constant.
    virtual bool marks_frame_lost() const = 0;

    /// In whose name it sends, where the protocol has nodes. For the start, before the first
    /// `encode`; outlives the encoder.
    virtual void speak_as(const dronecan::Voice& /*voice*/) {}

    /// Goes on as `before`, an encoder of the same protocol and settings: with its counters, so
    /// that readers see one sender.
    virtual void continue_from(const CanEncoder& before) = 0;

    /// Writes the frames of one snapshot, in the order in which they go out, and returns how many.
    /// `now` is when they go out: the age of the values is told where the format can.
    virtual std::size_t encode(const ChannelFrame& snapshot, Instant now,
                               std::span<CanFrame, kMostSnapshotFrames> frames) = 0;
};

}  // namespace tribus
