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
#include "transports/codecs/sbus_scale.h"

/// Futaba SBUS, both ways, and SBUS2 frames on the way in (docs/protocols/sbus.md).
namespace tribus {

extern const Protocol kSbusProtocol;

inline constexpr std::size_t kSbusFrameLength = 25;

/// What one frame says, in its own terms (docs/protocols/sbus.md, "Frame").
struct SbusFrame {
    SbusRaw raw{};  ///< 0 to 2047
    bool channel_17 = false;
    bool channel_18 = false;
    bool frame_lost = false;
    bool failsafe = false;
    std::uint8_t footer = 0;

    bool operator==(const SbusFrame&) const = default;
};

/// Reads 25 bytes without judging them.
SbusFrame parse_sbus(std::span<const std::uint8_t, kSbusFrameLength> wire);
/// Writes 25 bytes.
void emit_sbus(const SbusFrame& frame, std::span<std::uint8_t, kSbusFrameLength> wire);

/// Finds frames by content and by pauses. There is no checksum: a frame has the header, a zero high
/// nibble in its flags and a footer whose low nibble is 0, 4 or 8. 0x0F is common inside the
/// payload, so while it is unlocked the decoder wants a second frame behind as proof, with the slot
/// triples of SBUS2 between them or not. Once locked, a frame is taken with its last byte.
///
/// A pause locks it: the next byte is expected to begin a frame. So it does not matter what stands
/// between a frame and the next pause, and nothing behind a pause completes what stands before it.
///
/// Where no pause tells, and an expected frame is bad, it looks first where the next one stands if
/// one byte was lost, none, or one added; only then does it scan. A payload that itself looks like
/// a frame boundary, repeated by sticks that stand still, can thus not pull it out of step. Where
/// SBUS2 slots may be the bad part, it takes the place where the frame is most like the last one.
/// What remains: flags 0F on the wire, or a header mistaken for a slot, together with such a
/// payload.
class SbusDecoder final : public Decoder {
  public:
    explicit SbusDecoder(SbusScale scale = *SbusScale::named("betaflight")) : scale_(scale) {}

    void damaged_byte() override;
    bool silence(DecodedFrame& frame) override;
    void reset() override;
    std::optional<DecodedFrame> finish() override;
    std::span<const NamedCount> rejected() const override { return rejected_; }
    std::uint64_t skipped_bytes() const override { return skipped_bytes_; }
    std::span<const FrameDetail> details() const override;

  private:
    enum class State : std::uint8_t { unlocked, locked, recovering };
    enum class Verdict : std::uint8_t { no, undecided, yes };
    struct Judgement {
        Verdict verdict = Verdict::no;
        std::size_t wanted = 0;  ///< while undecided: bytes that would tell more
    };
    /// What one step came to: a frame stands at the front, or not yet, or more bytes are needed.
    enum class Step : std::uint8_t { again, frame, wait };
    using Wire = std::span<const std::uint8_t, kSbusFrameLength>;
    enum RejectCause : std::size_t { kFraming, kDamaged };

    /// Where a bad frame may end, the likeliest first: one byte of it was lost (a UART overruns, it
    /// does not invent), none, or one added; then, among slots, anywhere.
    static constexpr std::array kEnds = [] {
        std::array<std::size_t, kSbusFrameLength + 1> ends{kSbusFrameLength - 1, kSbusFrameLength,
                                                           kSbusFrameLength + 1};
        std::iota(ends.begin() + 3, ends.end(), std::size_t{1});
        return ends;
    }();
    static constexpr std::size_t kSlotLength = 3;
    static constexpr std::size_t kSlotsPerFrame = 8;
    static constexpr std::size_t kSlotsLength = kSlotLength * kSlotsPerFrame;
    /// A bad frame with one byte added, then a frame and a second one as proof, each with slots in
    /// front; and room for a damaged byte.
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
    bool last_frame_at(std::size_t start) const;
    std::size_t after_slots(std::size_t start) const;
    Judgement judge(std::size_t start) const;
    int likeness(std::size_t start) const;

    Step step();
    Step step_unlocked();
    Step step_locked();
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
    /// What stood in the place of a frame did not begin like one: it counts as a bad frame only if
    /// no pause follows, and a frame that ends with that pause is none of its bytes.
    bool stray_bytes_ = false;
    /// Of the first byte ever, or of the first behind a reset.
    std::uint64_t start_position_ = 0;
    std::size_t slots_left_ = 0;
    /// How far the search among slots has come: each end is judged once, in the order of `kEnds`.
    struct Search {
        std::size_t judged = 0;
        std::optional<std::size_t> found;
        int found_likeness = 0;
    };
    Search search_;
    /// The latest frame, and the one before: that one is beyond doubt, for the latest stood in its
    /// place behind it. They take turns.
    struct KeptFrame {
        alignas(Lanes) std::array<std::uint8_t, kSbusFrameLength> wire{};
    };
    std::array<KeptFrame, 2> frames_{};
    std::size_t latest_ = 0;
    SbusScale scale_;
    std::array<NamedCount, 2> rejected_{{{"framing"}, {"damaged"}}};
    std::uint64_t skipped_bytes_ = 0;

    // Taken from the latest frame when somebody asks.
    mutable SbusRaw raw_{};
    mutable std::array<std::uint16_t, 1> footer_{};
    std::array<FrameDetail, 2> details_{{{"raw", raw_, true}, {"footer", footer_, false}}};
};

/// Writes footer 00 and the flags as the frame has them. An absent channel is sent as 1500 us, an
/// absent 17 or 18 as off; 17 and 18 are on above 1500 us.
class SbusEncoder final : public Encoder {
  public:
    explicit SbusEncoder(SbusScale scale = *SbusScale::named("betaflight")) : scale_(scale) {}
    bool marks_frame_lost() const override { return true; }
    std::size_t encode(const ChannelFrame& frame,
                       std::span<std::uint8_t, kLongestSerialFrame> wire) const override;

  private:
    std::size_t encode_any(const ChannelFrame& frame,
                           std::span<std::uint8_t, kLongestSerialFrame> wire) const;

    SbusScale scale_;
};

}  // namespace tribus
