#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "core/can_frame.h"
#include "core/channel_frame.h"
#include "core/random_seed.h"
#include "core/time.h"
#include "transports/codecs/codec.h"

namespace tribus {

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

    /// Gives random bytes, for protocols with challenges. Call at the start, before the first
    /// `next`.
    virtual void use_seed(const RandomSeed& /*seed*/) {}
    /// Gives bytes that are random at each call, for the same. In the same way.
    virtual void use_random(RandomSource /*random*/) {}
    /// Gives the numbers of this end, for links whose receivers do not answer. Call at the start,
    /// before the first `next`. Must outlive the decoder.
    virtual void use_numbers(NumberReservation& /*numbers*/) {}
    /// The ids with which it answers. Constant.
    virtual std::span<const CanIdMatch> answered() const { return {}; }
    /// Answers at `now` the senders of the frames that were taken. Empty: it says nothing. Valid
    /// until the next call.
    virtual std::span<const CanFrame> answer(Instant /*now*/) { return {}; }
};

/// For protocols on CAN.
class CanEncoder : public Encoder {
  public:
    /// Writes the frames of one snapshot in sending order and returns their number. `now` is when
    /// they are sent, from which the age of the values follows in formats that carry it.
    virtual std::size_t write(const ChannelFrame& snapshot,
                              std::span<CanFrame, kMostSnapshotFrames> frames, Instant now) = 0;
    /// The ids of answers to its frames. Constant.
    virtual std::span<const CanIdMatch> heard() const { return {}; }
    /// Takes a frame that arrived at `received`; frames with other ids are ignored.
    virtual void hear(const CanFrame& /*frame*/, Instant /*received*/) {}
};

}  // namespace tribus
