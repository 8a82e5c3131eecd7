#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "core/can_frame.h"
#include "core/channel_frame.h"
#include "core/link_cause.h"
#include "core/random_seed.h"
#include "core/time.h"
#include "transports/codecs/line_buffer.h"

namespace tribus {

class NumberReservation;
class ValueBoard;
class WallClock;

namespace dronecan {
struct NodeIdentity;
}  // namespace dronecan

/// Upper limit of the length of a frame of any serial protocol, in bytes.
inline constexpr std::size_t kLongestSerialFrame = 104;

/// One frame found in a stream of bytes.
struct DecodedFrame {
    ChannelFrame channels{};
    /// Position of its first byte, counted from the first byte that the decoder was given.
    std::uint64_t first_byte = 0;
    std::size_t length = 0;
};

/// A counter with a name: how often something happened since the decoder was made.
struct NamedCount {
    std::string_view name;
    std::uint64_t count = 0;
};

/// A protocol's own value of the latest frame: one number, or a list of numbers.
struct FrameDetail {
    std::string_view name;
    std::span<const std::uint16_t> values;
    bool list = false;
};

/// What a sender says of its radio link. What it does not say is absent.
struct RadioStatistics {
    std::uint8_t link_quality = kNoLinkQuality;  ///< %
    std::optional<int> rssi_dbm{};               ///< of the antenna in use
    std::optional<int> snr_db{};
    std::optional<std::uint16_t> power_mw{};  ///< of the transmitter
    std::optional<std::uint8_t> mode{};       ///< number of the rate; its meaning is the maker's
    Instant received{};
};

/// What a decoder says of the frames that it refuses, in a fixed place; see
/// DecoderReport::write_fault.
struct FaultText {
    std::array<char, 160> text{};
    std::size_t length = 0;

    std::string_view view() const { return {text.data(), length}; }
};

/// Counters and details that every decoder reports.
class DecoderReport {
  public:
    DecoderReport() = default;
    DecoderReport(const DecoderReport&) = delete;
    DecoderReport& operator=(const DecoderReport&) = delete;
    virtual ~DecoderReport() = default;

    /// Refused frames by cause. The counts only ever increase.
    virtual std::span<const NamedCount> rejected() const = 0;
    /// Bytes that belonged to no frame and no known part of the protocol.
    virtual std::uint64_t skipped_bytes() const { return 0; }
    /// Protocol details of the frame that was returned last. Valid until the next call.
    virtual std::span<const FrameDetail> details() const { return {}; }
    /// Whether the arrivals show two senders of one id whose content does not tell them apart, so
    /// that the received frames are a mixture.
    virtual bool two_senders() const { return false; }
    /// What is wrong with the frames that it refuses, or marks failsafe itself, for people: which
    /// message, which signal, its value and what is allowed. Writes to the front of `text`, cut to
    /// its size; returns the length. 0: nothing that it could name. No heap.
    virtual std::size_t write_fault(std::span<char> /*text*/) const { return 0; }
    /// What bytes are of which no frame counts: `garbled`, or what a protocol with a key knows of
    /// them.
    virtual LinkCause why_garbled() const { return LinkCause::garbled; }
    /// The latest statistics of the radio link. Null if the protocol has none, or before the first.
    virtual const RadioStatistics* radio_statistics() const { return nullptr; }
    /// From now on the keys of `fresh` count, a decoder of the same protocol whose settings differ
    /// in its keys only. What the link was stays: who has a key that counts before and after does
    /// not notice it.
    virtual void use_keys_of(const DecoderReport& /*fresh*/) {}
};

/// Bytes in, frames out. Pure: no descriptor, clock, log or heap. Reads the given bytes in place
/// and keeps undecided ones in a fixed buffer. The count "damaged" of `rejected` is the number of
/// bytes with a parity or framing error; each of them spoils its frame. Thread-bound.
class ByteDecoder : public DecoderReport {
  public:
    /// Removes bytes from the front of `bytes` until a frame is complete, then fills `frame` and
    /// returns true; call again with the rest. Returns false when all bytes are taken and no
    /// further frame is complete. `received`, when the bytes were read, becomes the arrival of the
    /// frames that they complete.
    bool next(std::span<const std::uint8_t>& bytes, Instant received, DecodedFrame& frame) {
        if (buffer_.keep(bytes)) {
            bytes = {};
            return false;
        }
        const Taken taken = decode(bytes, received, frame);
        bytes = bytes.subspan(taken.bytes);
        return taken.frame;
    }

    /// A byte with a parity or framing error stood here in the stream. Before this, call `next`
    /// until it returns false.
    virtual void damaged_byte() = 0;

    /// The line was silent here for longer than a byte takes: unfinished bytes before it are cut
    /// off, and a frame may begin with the next byte. Returns true and fills `frame`, except for
    /// its arrival, if the pause shows that bytes before it are a frame; call until it returns
    /// false, and only between calls of `next`.
    virtual bool silence(DecodedFrame& frame) = 0;
    /// How old the values of the frame that was returned last are when its bytes arrive. Zero if
    /// the format does not tell it.
    Duration age() const { return age_; }
    /// Number of bytes that wait for others to be decided. A pause now would cut them off.
    std::size_t waiting() const { return buffer_.size(); }

    /// The line was unplugged and may be another one when it returns: forgets all bytes so far.
    virtual void reset() = 0;

    /// The recording ends here. Returns a frame that lacked only the bytes after it.
    virtual std::optional<DecodedFrame> finish() = 0;

    /// Gives the time of day, by which it judges whether signed frames are old. Call at the start,
    /// before the first `next`. Must outlive the decoder.
    virtual void use_clock(const WallClock& /*clock*/) {}
    /// Gives random bytes, for protocols with challenges. Call at the start, before the first
    /// `next`.
    virtual void use_seed(const RandomSeed& /*seed*/) {}
    /// Gives bytes that are random at each call, for the same. In the same way.
    virtual void use_random(RandomSource /*random*/) {}
    /// Gives the numbers of this end, for links whose receivers do not answer. Call at the start,
    /// before the first `next`. Must outlive the decoder.
    virtual void use_numbers(NumberReservation& /*numbers*/) {}
    /// Answers at `now` the sender of the datagram that was taken last. Empty: it says nothing.
    /// Valid until the next call. Only protocols with Protocol::link_with_key answer.
    virtual std::span<const std::uint8_t> answer(Instant /*now*/) { return {}; }

  protected:
    /// Bytes that were removed from the front of a read, and whether they completed a frame.
    struct Taken {
        std::size_t bytes = 0;
        bool frame = false;
    };

    LineBuffer buffer_;
    Duration age_{};

  private:
    /// Like `next`, for bytes that decide something together with those in the buffer.
    virtual Taken decode(std::span<const std::uint8_t> bytes, Instant received,
                         DecodedFrame& frame) = 0;
};

/// What the receiver of an output's frames says of itself, in protocols whose receivers answer.
struct Answers {
    /// Signs of life since the encoder was made.
    std::uint32_t heard = 0;
    /// The same of receivers that the frames are not for, and the number of the latest of them.
    std::uint32_t heard_others = 0;
    std::uint8_t other = 0;
    /// An answer has shown channels that were sent.
    bool effect = false;
    /// What the receiver is, by the protocol's own number. Meaningless before `heard`.
    std::uint16_t kind = 0;
};

/// Why an encoder writes no channels.
enum class Withheld : std::uint8_t {
    nothing,
    no_receiver,  ///< no receiver with the same key answers
    no_numbers,   ///< no number is stored that it may use
};

/// Whether the receiver of an output's frames is heard, in protocols whose receivers talk by
/// themselves.
enum class Hearing : std::uint8_t {
    not_awaited,  ///< nothing need be heard, or not yet
    heard,
    silent,      ///< nothing comes back, but perhaps what was sent
    unreadable,  ///< bytes come back, and none of them are a frame of it
};

/// A frame of channels in, what a link carries out. Every frame has an encoding. Pure: no
/// descriptor, clock or log, and no heap after construction; may keep state. Thread-bound.
class Encoder {
  public:
    Encoder() = default;
    Encoder(const Encoder&) = delete;
    Encoder& operator=(const Encoder&) = delete;
    virtual ~Encoder() = default;

    /// Whether the format can mark a frame as frame lost. Constant.
    virtual bool marks_frame_lost() const = 0;
    /// The channels of `frame` that need a value on the wire, one bit each. The others can be sent
    /// as absent, or are not sent.
    virtual std::uint32_t needed_channels(const ChannelFrame& /*frame*/) const {
        return kAllChannels;
    }

    /// Gives the board of the named values that it sends; they are looked up here by name. Call at
    /// the start, before the first `write`. A value has no number without a board or if the board
    /// lacks its name. The board must outlive the encoder.
    virtual void use(const ValueBoard& /*board*/) {}
    /// Sets the node that it sends as, for protocols with nodes. Call at the start, before the
    /// first `write`. Must outlive the encoder.
    virtual void send_as(const dronecan::NodeIdentity& /*identity*/) {}
    /// Gives the time of day, for signatures. Call at the start, before the first `write`. Must
    /// outlive the encoder.
    virtual void use_clock(const WallClock& /*clock*/) {}
    /// Gives random bytes, for protocols with challenges. Call at the start, before the first
    /// `write`.
    virtual void use_seed(const RandomSeed& /*seed*/) {}
    /// Gives the numbers of this end, for links whose receivers do not answer. Call at the start,
    /// before the first `write`. Must outlive the encoder.
    virtual void use_numbers(NumberReservation& /*numbers*/) {}
    /// Continues where `before`, an encoder of the same protocol and settings, ended, so that
    /// receivers see one sender.
    virtual void continue_from(const Encoder& /*before*/) {}

    /// How often it wants to be asked for a frame after the end, to say that no more will follow.
    /// Constant.
    virtual int farewells() const { return 0; }

    /// What was heard of the receiver.
    virtual Answers answers() const { return {}; }
    /// Whether the receiver is heard at `now`, while frames are sent to it.
    virtual Hearing hearing(Instant /*now*/) const { return Hearing::not_awaited; }
    /// Whether it may write no channels, whatever it is given. Constant.
    virtual bool may_withhold() const { return false; }
    /// Why the latest `write` had no channels in it.
    virtual Withheld withheld() const { return Withheld::nothing; }

    /// CAN: whether some of its frames are FD. Constant.
    virtual bool uses_fd() const { return false; }
    /// CAN: the ids that it sends. No other node on the bus may send them. Constant.
    virtual std::span<const CanIdMatch> sent() const { return {}; }
};

/// What the receiver of an output's frames asks for: a frame at once, or a timing of all frames.
struct AskedTiming {
    bool at_once = false;
    Duration period{};
    /// By how much more than the period the next frame should come after the one before; negative:
    /// by how much less. Once.
    Duration later{};
};

/// For protocols on bytes.
class ByteEncoder : public Encoder {
  public:
    /// Writes one frame to the front of `wire` and returns its length in bytes. `now` is when it is
    /// sent.
    virtual std::size_t write(const ChannelFrame& frame,
                              std::span<std::uint8_t, kLongestSerialFrame> wire, Instant now) = 0;
    /// What is sent in the place of a frame while the output is silent: in some protocols it tells
    /// that there are no channels. Called each period. Returns its length; 0: nothing.
    virtual std::size_t write_silence(std::span<std::uint8_t, kLongestSerialFrame> /*wire*/,
                                      Instant /*now*/) {
        return 0;
    }
    /// Takes undamaged bytes that came back on the same line, read at `now`. Returns the timing
    /// that they ask for last, if they do.
    virtual std::optional<AskedTiming> hear(std::span<const std::uint8_t> /*bytes*/,
                                            Instant /*now*/) {
        return std::nullopt;
    }
    /// Tells it that bytes are missing behind those it heard so far: they were damaged or
    /// discarded, or the line was unplugged.
    virtual void forget_heard() {}
};

}  // namespace tribus
