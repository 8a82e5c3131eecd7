#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <optional>
#include <span>

#include "core/channel_frame.h"
#include "transports/codecs/codec.h"
#include "transports/codecs/line_buffer.h"
#include "transports/codecs/protocol.h"
#include "transports/codecs/sbus/scale.h"

/// Futaba SBUS, both directions, and SBUS2 frames as input (docs/protocols/sbus.md).
namespace tribus {

extern const Protocol kSbusProtocol;

inline constexpr std::size_t kSbusFrameLength = 25;

/// Content of one frame in the terms of the wire format (docs/protocols/sbus.md, "Frame").
struct SbusFrame {
    SbusRaw raw{};  ///< 0 to 2047
    bool channel_17 = false;
    bool channel_18 = false;
    bool frame_lost = false;
    bool failsafe = false;
    std::uint8_t footer = 0;

    bool operator==(const SbusFrame&) const = default;
};

/// Reads 25 bytes. Does not check them.
SbusFrame parse_sbus(std::span<const std::uint8_t, kSbusFrameLength> wire);
/// Writes 25 bytes.
void emit_sbus(const SbusFrame& frame, std::span<std::uint8_t, kSbusFrameLength> wire);

/// Finds frames by content and by pauses. SBUS has no checksum: a frame has the header, a zero high
/// nibble in its flags and a footer whose low nibble is 0, 4 or 8. 0x0F is common inside the
/// payload, so an unlocked decoder requires a second frame after it as proof, with or without SBUS2
/// slots in between. A locked decoder accepts a frame with its last byte, but wants the second
/// frame or a pause where a footer announces slots and the frame before had none. Thread-bound.
///
/// FrSky's frames of 24 channels have 36 bytes, and channel 17 in the place of the flags. Until a
/// frame has shown that the line has others, and again after 36 such bytes between two pauses, a
/// frame needs a second one behind it, or pauses that leave just its bytes between them (or twice
/// the same few bytes more), so that none of 36 is read as one of 25, even if it lost bytes.
///
/// A pause locks the decoder: the next byte is expected to begin a frame. So bytes between a frame
/// and the next pause do no harm, and bytes after a pause never complete bytes before it.
///
/// If a locked decoder meets a bad frame without a pause after it, it first looks where the next
/// frame would be with one byte lost, none, or one added; only then does it scan. A payload that
/// looks like a frame boundary and is repeated by sticks at rest can therefore not pull it out of
/// step. If SBUS2 slots may be the bad part, it takes the place whose frame is most like the last
/// one. It can still fail on flags 0F on the wire, or a header mistaken for a slot, together with
/// such a payload.
class SbusDecoder final : public ByteDecoder {
  public:
    explicit SbusDecoder(SbusScale scale = *SbusScale::named("betaflight")) : scale_(scale) {}

    void damaged_byte() override;
    bool silence(DecodedFrame& frame) override;
    void reset() override;
    std::optional<DecodedFrame> finish() override;
    std::span<const NamedCount> rejected() const override { return rejected_; }
    std::uint64_t skipped_bytes() const override { return skipped_bytes_; }
    std::span<const FrameDetail> details() const override;
    std::size_t write_fault(std::span<char> text) const override;

  private:
    /// `expecting`: the next byte is in the place of a frame, as in `locked`, but the frame may be
    /// one of 24 channels.
    enum class State : std::uint8_t { unlocked, expecting, locked, recovering };
    enum class Verdict : std::uint8_t { no, undecided, yes };
    struct Judgement {
        Verdict verdict = Verdict::no;
        std::size_t wanted = 0;  ///< if undecided: number of bytes that decides more
    };
    /// Result of one step: call it again, a frame is at the front, or more bytes are needed.
    enum class Step : std::uint8_t { again, frame, wait };
    using Wire = std::span<const std::uint8_t, kSbusFrameLength>;
    enum RejectCause : std::size_t { kFraming, kDamaged };

    /// Possible lengths of a bad frame, the likeliest first: one byte lost (a UART overruns, it
    /// does not invent bytes), none, or one added; among slots, then any other length.
    static constexpr std::array kEnds = [] {
        std::array<std::size_t, kSbusFrameLength + 1> ends{kSbusFrameLength - 1, kSbusFrameLength,
                                                           kSbusFrameLength + 1};
        std::iota(ends.begin() + 3, ends.end(), std::size_t{1});
        return ends;
    }();
    static constexpr std::size_t kSlotLength = 3;
    static constexpr std::size_t kSlotsPerFrame = 8;
    static constexpr std::size_t kSlotsLength = kSlotLength * kSlotsPerFrame;
    /// A bad frame with one byte added, then a frame and a second one as proof, each with slots
    /// before it, and room for a damaged byte.
    static_assert((kSbusFrameLength + 1) + 2 * (kSlotsLength + kSbusFrameLength) + 1 <=
                  LineBuffer::kCapacity);

    Taken decode(std::span<const std::uint8_t> bytes, Instant received,
                 DecodedFrame& frame) override;
    Taken decode_unlocked(std::span<const std::uint8_t> bytes, Instant received,
                          DecodedFrame& frame);
    Taken decode_header(std::span<const std::uint8_t> bytes, std::span<const std::uint8_t> rest,
                        Instant received, DecodedFrame& frame);
    Taken refuse_kept(std::uint8_t last);
    void pass_noise(std::size_t noise, std::span<const std::uint8_t>& bytes);
    Taken decode_byte(std::span<const std::uint8_t> bytes, Instant received, DecodedFrame& frame);
    Taken decode_pieces(std::span<const std::uint8_t> bytes, Instant received, DecodedFrame& frame);
    bool decode_locked(std::span<const std::uint8_t>& bytes, Instant received, DecodedFrame& frame);
    bool decode_in_steps(std::span<const std::uint8_t>& bytes, Instant received,
                         DecodedFrame& frame);
    bool well_formed(std::size_t start) const;
    bool only_damaged(std::size_t start) const;
    bool wide_burst_ends() const;
    bool may_be_frame_and_stray_bytes(std::size_t burst) const;
    /// Number of bytes since the latest pause.
    std::size_t burst_size() const {
        return static_cast<std::size_t>(buffer_.first_position() + buffer_.size() - burst_begin_);
    }
    bool in_step() const { return state_ == State::locked || state_ == State::expecting; }
    bool footer_expected(std::uint8_t footer) const;
    bool frame_in_front() const;
    bool last_frame_at(std::size_t start) const;
    std::size_t after_slots(std::size_t start) const;
    Judgement judge(std::size_t start) const;
    Judgement judge_front() const;
    int likeness(std::size_t start) const;

    Step step();
    Step step_unlocked();
    Step step_locked();
    Step step_expecting();
    Step step_recovering();
    Step step_recovering_among_slots();
    void give_up_recovering();
    void skip(std::size_t count);
    void end_recovering(State next);
    void take_front(Instant received, DecodedFrame& frame);
    void lock_onto(std::size_t start);
    void read_frame(Wire wire, Instant received, DecodedFrame& frame);
    void scale_each(ChannelFrame& channels) const;
    const std::array<std::uint8_t, kSbusFrameLength>& latest() const {
        return frames_[latest_].wire;
    }
    const std::array<std::uint8_t, kSbusFrameLength>& trusted() const {
        return frames_[latest_ ^ 1U].wire;
    }
    Wire front() const { return buffer_.view(0, kSbusFrameLength).first<kSbusFrameLength>(); }

    State state_ = State::unlocked;
    /// The bytes in the place of a frame did not begin like one. They count as a bad frame only if
    /// no pause follows, and do not belong to a frame that ends with that pause.
    bool stray_bytes_ = false;
    /// A frame of 16 channels came, and none of 24 since then.
    bool length_shown_ = false;
    /// Position of the first byte behind the latest pause.
    std::uint64_t burst_begin_ = 0;
    /// Number of bytes between the two latest pauses that had some between them.
    std::size_t previous_burst_ = 0;
    /// Position of the first byte of the stream, or of the first one after a reset.
    std::uint64_t start_position_ = 0;
    std::size_t slots_left_ = 0;
    /// Progress of the search among slots: each length is checked once, in the order of `kEnds`.
    struct Search {
        std::size_t judged = 0;
        std::optional<std::size_t> found;
        int found_likeness = 0;
    };
    Search search_;
    /// The latest frame and the one before it, in turns. The earlier one is beyond doubt, because
    /// the latest came in the expected place after it.
    struct KeptFrame {
        alignas(Lanes) std::array<std::uint8_t, kSbusFrameLength> wire{};
    };
    std::array<KeptFrame, 2> frames_{};
    std::size_t latest_ = 0;
    SbusScale scale_;
    std::array<NamedCount, 2> rejected_{{{"framing"}, {"damaged"}}};
    std::uint64_t skipped_bytes_ = 0;

    // Filled from the latest frame on request.
    mutable SbusRaw raw_{};
    mutable std::array<std::uint16_t, 1> footer_{};
    std::array<FrameDetail, 2> details_{{{"raw", raw_, true}, {"footer", footer_, false}}};
};

/// Writes footer 00 and the flags of the frame. An absent channel is sent as 1500 us, an absent 17
/// or 18 as off; 17 and 18 are on above 1500 us. Pure and reentrant.
class SbusEncoder final : public ByteEncoder {
  public:
    explicit SbusEncoder(SbusScale scale = *SbusScale::named("betaflight")) : scale_(scale) {}
    bool marks_frame_lost() const override { return true; }
    std::size_t write(const ChannelFrame& frame, std::span<std::uint8_t, kLongestSerialFrame> wire,
                      Instant now) override;

  private:
    std::size_t encode_any(const ChannelFrame& frame,
                           std::span<std::uint8_t, kLongestSerialFrame> wire) const;

    SbusScale scale_;
};

}  // namespace tribus
