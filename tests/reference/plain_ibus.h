#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "core/channel_frame.h"
#include "tests/reference/plain_line_buffer.h"
#include "transports/codecs/codec.h"
#include "transports/codecs/ibus/ibus.h"

/// The plain form of the i.Bus codec. Tests compare the fast codec with it.
namespace tribus::reference {

/// What IbusDecoder must do, with each step written out.
class PlainIbusDecoder {
  public:
    explicit PlainIbusDecoder(IbusSlots slots = IbusSlots::nibbles) : slots_(slots) {}

    std::optional<DecodedFrame> next(std::span<const std::uint8_t>& bytes, Instant received);
    void damaged_byte();
    std::optional<DecodedFrame> silence();
    void reset();
    std::optional<DecodedFrame> finish() { return std::nullopt; }
    std::span<const NamedCount> rejected() const { return rejected_; }
    std::uint64_t skipped_bytes() const { return skipped_bytes_; }

  private:
    enum class Kind : std::uint8_t { noise, undecided, servo, ia6, ibus2 };
    struct Candidate {
        Kind kind = Kind::noise;
        std::size_t length = 0;  ///< bytes that the buffer needs before this can be judged
    };
    enum RejectCause : std::size_t { kChecksum, kDamaged, kIbus2, kLength };

    Candidate candidate() const;
    bool checksum_holds(const Candidate& candidate) const;
    std::optional<DecodedFrame> judge_whole(const Candidate& candidate, Instant received);
    bool length_counts(std::size_t length);
    void judge_bad(const Candidate& candidate);
    void skip(std::size_t count);
    DecodedFrame take_frame(const Candidate& candidate, Instant received);

    /// One byte longer than the longest candidate, so that a damaged byte always has room.
    PlainLineBuffer<kLongestSerialFrame> buffer_;
    IbusSlots slots_;
    /// Length of the frames that count. 0: none has come yet.
    std::size_t usual_length_ = 0;
    std::size_t other_length_ = 0;
    int others_in_a_row_ = 0;
    std::array<NamedCount, 4> rejected_{{{"checksum"}, {"damaged"}, {"ibus2"}, {"length"}}};
    std::uint64_t skipped_bytes_ = 0;
};

/// What IbusEncoder must do, slot by slot.
class PlainIbusEncoder {
  public:
    explicit PlainIbusEncoder(std::size_t channel_count = 14) : channel_count_(channel_count) {}
    std::size_t encode(const ChannelFrame& frame,
                       std::span<std::uint8_t, kLongestSerialFrame> wire) const;

  private:
    std::size_t channel_count_;
};

}  // namespace tribus::reference
