#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <optional>
#include <span>

#include "core/channel_frame.h"
#include "tests/reference/plain_line_buffer.h"
#include "transports/codecs/codec.h"
#include "transports/codecs/sbus/sbus.h"
#include "transports/codecs/sbus/scale.h"

/// The plain form of the SBUS codec. Tests compare the fast codec with it.
namespace tribus::reference {

/// Reads 25 bytes without checking them.
SbusFrame plain_parse_sbus(std::span<const std::uint8_t, kSbusFrameLength> wire);
/// Writes 25 bytes.
void plain_emit_sbus(const SbusFrame& frame, std::span<std::uint8_t, kSbusFrameLength> wire);

/// What SbusDecoder must do, byte by byte, with each step written out.
class PlainSbusDecoder {
  public:
    explicit PlainSbusDecoder(SbusScale scale = *SbusScale::named("betaflight")) : scale_(scale) {}
    /// `details` points to members of this object, so it cannot be copied.
    PlainSbusDecoder(const PlainSbusDecoder&) = delete;
    PlainSbusDecoder& operator=(const PlainSbusDecoder&) = delete;
    ~PlainSbusDecoder() = default;

    std::optional<DecodedFrame> next(std::span<const std::uint8_t>& bytes, Instant received);
    void damaged_byte();
    std::optional<DecodedFrame> silence();
    void reset();
    std::optional<DecodedFrame> finish();
    std::span<const NamedCount> rejected() const { return rejected_; }
    std::uint64_t skipped_bytes() const { return skipped_bytes_; }
    std::span<const FrameDetail> details() const { return details_; }

  private:
    enum class State : std::uint8_t { unlocked, expecting, locked, recovering };
    enum class Verdict : std::uint8_t { no, undecided, yes };
    enum RejectCause : std::size_t { kFraming, kDamaged };

    /// Lengths that a bad frame may have, the likeliest first: one byte lost (a UART may overrun,
    /// but it does not add bytes), none lost, one added; then, among slots, any length.
    static constexpr std::array kEnds = [] {
        std::array<std::size_t, kSbusFrameLength + 1> ends{kSbusFrameLength - 1, kSbusFrameLength,
                                                           kSbusFrameLength + 1};
        std::iota(ends.begin() + 3, ends.end(), std::size_t{1});
        return ends;
    }();
    static constexpr std::size_t kSlotLength = 3;
    static constexpr std::size_t kSlotsPerFrame = 8;
    static constexpr std::size_t kSlotsLength = kSlotLength * kSlotsPerFrame;
    /// A bad frame with one byte added, then two frames as proof, each with slots before it, and
    /// room for a damaged byte.
    static constexpr std::size_t kCapacity =
        (kSbusFrameLength + 1) + 2 * (kSlotsLength + kSbusFrameLength) + 1;

    bool well_formed(std::size_t start) const;
    bool only_damaged(std::size_t start) const;
    std::size_t after_slots(std::size_t start) const;
    Verdict judge(std::size_t start) const;
    int likeness(std::size_t start) const;
    bool is_wide() const;
    bool wide_burst() const;

    /// Each function does one step. It returns false when it needs more bytes.
    bool step_unlocked();
    bool step_locked();
    bool step_recovering();
    void skip(std::size_t count);
    void end_recovering(State next);
    void lock_onto(std::size_t start);
    DecodedFrame take_frame(Instant received);

    PlainLineBuffer<kCapacity> buffer_;
    State state_ = State::unlocked;
    bool frame_ready_ = false;
    /// There is no header where a frame should be. It counts as an error if a frame follows without
    /// a pause.
    bool stray_bytes_ = false;
    /// Frames have 25 bytes, as what followed one has shown; not the 36 of 24 channels.
    bool length_shown_ = false;
    std::uint64_t burst_begin_ = 0;
    std::uint64_t previous_burst_ = 0;
    std::uint64_t start_position_ = 0;
    std::size_t slots_left_ = 0;
    std::array<std::uint8_t, kSbusFrameLength> latest_{};
    /// The frame before the latest. It is beyond doubt because the latest followed in its place.
    std::array<std::uint8_t, kSbusFrameLength> trusted_{};
    SbusScale scale_;
    std::array<NamedCount, 2> rejected_{{{"framing"}, {"damaged"}}};
    std::uint64_t skipped_bytes_ = 0;

    std::array<std::uint16_t, kSbusChannels> raw_{};
    std::array<std::uint16_t, 1> footer_{};
    std::array<FrameDetail, 2> details_{{{"raw", raw_, true}, {"footer", footer_, false}}};
};

/// What SbusEncoder must do, channel by channel.
class PlainSbusEncoder {
  public:
    explicit PlainSbusEncoder(SbusScale scale = *SbusScale::named("betaflight")) : scale_(scale) {}
    std::size_t encode(const ChannelFrame& frame,
                       std::span<std::uint8_t, kLongestSerialFrame> wire) const;

  private:
    SbusScale scale_;
};

}  // namespace tribus::reference
