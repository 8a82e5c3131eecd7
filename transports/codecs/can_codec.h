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
struct NodeIdentity;
}  // namespace dronecan

/// CAN frames in, snapshots of the channels out. Publishes only whole snapshots whose frames belong
/// together. Pure: no descriptor, clock or log, and no heap after construction. Thread-bound.
class CanDecoder : public DecoderReport {
  public:
    /// Whether some of its frames are FD. Constant.
    virtual bool uses_fd() const { return false; }
    /// The ids that it reads. Constant.
    virtual std::span<const CanIdMatch> wanted() const = 0;

    /// Takes one frame that arrived at `received`; frames with other ids are ignored. Returns the
    /// snapshot that the frame completes, if any. `received` of the snapshot is when its values
    /// were fresh: the arrival, or earlier if the sender gives their age.
    virtual std::optional<ChannelFrame> next(const CanFrame& frame, Instant received) = 0;
};

/// A snapshot of the channels in, CAN frames out. Pure; keeps only counters. Every snapshot has an
/// encoding. Thread-bound.
class CanEncoder {
  public:
    CanEncoder() = default;
    CanEncoder(const CanEncoder&) = delete;
    CanEncoder& operator=(const CanEncoder&) = delete;
    virtual ~CanEncoder() = default;

    /// Whether some of its frames are FD. Constant.
    virtual bool uses_fd() const { return false; }
    /// The ids that it sends. No other node on the bus may send them. Constant.
    virtual std::span<const CanIdMatch> sent() const = 0;

    /// Gives the board of the named values that it sends; they are looked up here by name. Call at
    /// the start, before the first `encode`. A value has no number without a board or if the board
    /// lacks its name. The board must outlive the encoder.
    virtual void use(const ValueBoard& /*board*/) {}

    /// The channels that need a value on the wire, one bit each. The others can be sent as absent,
    /// or are not sent.
    virtual std::uint32_t needed_channels(const ChannelFrame& snapshot) const = 0;
    /// Whether the format can mark a snapshot as frame lost. Constant.
    virtual bool marks_frame_lost() const = 0;

    /// Sets the node that it sends as, for protocols with nodes. Call at the start, before the
    /// first `encode`. Must outlive the encoder.
    virtual void send_as(const dronecan::NodeIdentity& /*identity*/) {}

    /// Continues with the counters of `before`, an encoder of the same protocol and settings, so
    /// that receivers see one sender.
    virtual void continue_from(const CanEncoder& before) = 0;

    /// Writes the frames of one snapshot in sending order and returns their number. `now` is when
    /// they are sent, from which the age of the values follows in formats that carry it.
    virtual std::size_t encode(const ChannelFrame& snapshot, Instant now,
                               std::span<CanFrame, kMostSnapshotFrames> frames) = 0;
};

}  // namespace tribus
