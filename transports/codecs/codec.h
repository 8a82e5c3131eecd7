#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "core/channel_frame.h"
#include "core/time.h"
#include "transports/codecs/line_buffer.h"

namespace tribus {

/// No frame of any serial protocol is longer.
inline constexpr std::size_t kLongestSerialFrame = 64;

/// One frame found in a stream of bytes.
struct DecodedFrame {
    ChannelFrame channels{};
    /// Position of its first byte, counted from the first byte that the decoder was ever given.
    std::uint64_t first_byte = 0;
    std::size_t length = 0;
};

/// A number with a name: how often something happened since the decoder was made.
struct NamedCount {
    std::string_view name;
    std::uint64_t count = 0;
};

/// A protocol's own view of the latest frame: one number, or a list of them.
struct FrameDetail {
    std::string_view name;
    std::span<const std::uint16_t> values;
    bool list = false;
};

/// What every decoder tells of its work, whatever it decodes.
class DecoderReport {
  public:
    DecoderReport() = default;
    DecoderReport(const DecoderReport&) = delete;
    DecoderReport& operator=(const DecoderReport&) = delete;
    virtual ~DecoderReport() = default;

    /// What was refused, by cause. Only ever incremented.
    virtual std::span<const NamedCount> rejected() const = 0;
    /// Bytes that belonged to no frame and no known part of the protocol.
    virtual std::uint64_t skipped_bytes() const { return 0; }
    /// What the protocol knows of the frame that was returned last. Valid until the next call.
    virtual std::span<const FrameDetail> details() const { return {}; }
    /// Arrivals showed that two senders share an id where the content cannot tell them apart: what
    /// is read mixes them.
    virtual bool two_senders() const { return false; }
};

/// Bytes in, frames out. Pure: no descriptor, clock, log or heap; works in the bytes that it is
/// given and keeps what it cannot judge yet in a fixed buffer. `rejected` counts under "damaged"
/// the bytes that had a parity or framing error, each of which kills its frame. Thread-bound: one
/// thread at a time.
class Decoder : public DecoderReport {
  public:
    /// Takes bytes off the front of `bytes` until a frame is complete, fills `frame` with it and
    /// says so; call again with the rest. False when all bytes are taken and no further frame is
    /// complete. `received`, when the bytes were read, is told of what they complete or release.
    bool next(std::span<const std::uint8_t>& bytes, Instant received, DecodedFrame& frame) {
        if (buffer_.keep(bytes)) {
            bytes = {};
            return false;
        }
        const Taken taken = decode(bytes, received, frame);
        bytes = bytes.subspan(taken.bytes);
        return taken.frame;
    }

    /// A byte stood here in the stream, but it came with a parity or framing error. Call `next`
    /// until it returns false before this.
    virtual void damaged_byte() = 0;

    /// Nothing stood on the line here for longer than a byte takes: what came before and is no
    /// whole frame is cut off, and a frame may begin with the next byte. Says whether the pause
    /// shows that bytes before it are a frame, and fills `frame` with it, but for when it was
    /// received; call until it returns false, and only between calls of `next`.
    virtual bool silence(DecodedFrame& frame) = 0;
    /// So many bytes wait for others that would decide about them: a pause now would cut them off.
    std::size_t waiting() const { return buffer_.size(); }

    /// The line was taken away, and may be another one when it is back: nothing that came before
    /// counts for what comes.
    virtual void reset() = 0;

    /// The recording ends here: returns a frame that only lacked what would have followed it.
    virtual std::optional<DecodedFrame> finish() = 0;

  protected:
    /// What was taken off the front of a read, and whether a frame came of it.
    struct Taken {
        std::size_t bytes = 0;
        bool frame = false;
    };

    LineBuffer buffer_;

  private:
    /// As `next`, with bytes that decide something together with those that are kept.
    virtual Taken decode(std::span<const std::uint8_t> bytes, Instant received,
                         DecodedFrame& frame) = 0;
};

/// A frame in, bytes out. Pure and reentrant. Total: every frame has an encoding.
class Encoder {
  public:
    virtual ~Encoder() = default;
    /// The channels that need a value on the wire, a bit each: of the others the format can say
    /// that they are absent, or it does not have them. Constant.
    virtual std::uint32_t needed_channels() const { return kAllChannels; }
    /// The format can say that a frame is marked frame-lost. Constant.
    virtual bool marks_frame_lost() const = 0;
    /// Writes one frame to the front of `wire` and returns its length.
    virtual std::size_t encode(const ChannelFrame& frame,
                               std::span<std::uint8_t, kLongestSerialFrame> wire) const = 0;
};

}  // namespace tribus
