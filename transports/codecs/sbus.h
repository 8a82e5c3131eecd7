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

/// Futaba SBUS, both ways, and SBUS2 frames on the way in (ibus-sbus.md section 3).
namespace tribus {

extern const Protocol kSbusProtocol;

inline constexpr std::size_t kSbusFrameLength = 25;
inline constexpr std::size_t kSbusChannels = 16;

/// What one frame says, in its own terms (3.2).
struct SbusFrame {
    std::array<std::uint16_t, kSbusChannels> raw{};  ///< 0 to 2047
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

/// Finds frames by content. There is no checksum: a frame has the header, a zero high nibble in its
/// flags and a footer whose low nibble is 0, 4 or 8. 0x0F is common inside the payload, so while it
/// is unlocked the decoder wants a second frame behind as proof, with the slot triples of SBUS2
/// between them or not. Once locked, a frame is taken as soon as its last byte is there.
///
/// When an expected frame is bad, it looks first where the next one stands if one byte was lost,
/// none, or one added; only then does it scan. A payload that itself looks like a frame boundary,
/// repeated by sticks that stand still, can thus not pull it out of step. Where SBUS2 slots may be
/// the bad part, it takes the place where the frame is most like the last one. What remains: flags
/// 0F on the wire, or a header mistaken for a slot, together with such a payload.
class SbusDecoder final : public Decoder {
  public:
    explicit SbusDecoder(SbusScale scale = *SbusScale::named("betaflight")) : scale_(scale) {}

    std::optional<DecodedFrame> next(std::span<const std::uint8_t>& bytes,
                                     Instant received) override;
    void damaged_byte() override;
    std::optional<DecodedFrame> finish() override;
    std::span<const NamedCount> rejected() const override { return rejected_; }
    std::uint64_t skipped_bytes() const override { return skipped_bytes_; }
    std::span<const FrameDetail> details() const override { return details_; }

  private:
    enum class State : std::uint8_t { unlocked, locked, recovering };
    enum class Verdict : std::uint8_t { no, undecided, yes };
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
    static constexpr std::size_t kCapacity =
        (kSbusFrameLength + 1) + 2 * (kSlotsLength + kSbusFrameLength) + 1;

    bool well_formed(std::size_t start) const;
    bool only_damaged(std::size_t start) const;
    std::size_t after_slots(std::size_t start) const;
    Verdict judge(std::size_t start) const;
    int likeness(std::size_t start) const;

    /// Each does one step and says whether it could; if not, more bytes are needed.
    bool step_unlocked();
    bool step_locked();
    bool step_recovering();
    void skip(std::size_t count);
    void lock_onto(std::size_t start);
    DecodedFrame take_frame(Instant received);

    LineBuffer<kCapacity> buffer_;
    State state_ = State::unlocked;
    bool frame_ready_ = false;
    std::size_t slots_left_ = 0;
    std::array<std::uint8_t, kSbusFrameLength> latest_{};
    /// The frame before the latest: beyond doubt, for the latest stood in its place behind it.
    std::array<std::uint8_t, kSbusFrameLength> trusted_{};
    SbusScale scale_;
    std::array<NamedCount, 2> rejected_{{{"framing"}, {"damaged"}}};
    std::uint64_t skipped_bytes_ = 0;

    std::array<std::uint16_t, kSbusChannels> raw_{};
    std::array<std::uint16_t, 1> footer_{};
    std::array<FrameDetail, 2> details_{{{"raw", raw_, true}, {"footer", footer_, false}}};
};

/// Writes footer 00 and the flags as the frame has them. An absent channel is sent as 1500 us, an
/// absent 17 or 18 as off; 17 and 18 are on above 1500 us.
class SbusEncoder final : public Encoder {
  public:
    explicit SbusEncoder(SbusScale scale = *SbusScale::named("betaflight")) : scale_(scale) {}
    std::size_t encode(const ChannelFrame& frame,
                       std::span<std::uint8_t, kLongestSerialFrame> wire) const override;

  private:
    SbusScale scale_;
};

}  // namespace tribus
