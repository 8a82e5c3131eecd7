#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "core/channel_frame.h"
#include "transports/codecs/codec.h"
#include "transports/codecs/line_buffer.h"
#include "transports/codecs/protocol.h"
#include "transports/codecs/wire_words.h"

/// FlySky i.Bus servo frames, both directions (docs/protocols/ibus.md).
namespace tribus {

extern const Protocol kIbusProtocol;

/// Layout of the 14 slots of 16 bits.
enum class IbusSlots : std::uint8_t {
    nibbles,  ///< 12 bits of one channel, and 4 bits of channels 15 to 18 on top
    plain,    ///< 16 bits of one channel: some senders, without channels 15 to 18
};

/// Finds frames by header, length and checksum, and continues the search inside its buffer after a
/// bad frame. Needs no gaps: a real receiver leaves 0.95 ms between frames (docs/protocols/ibus.md,
/// "Period and gaps"), less than many readers wait for. If a pause shows that a frame has ended, it
/// does not wait for more bytes.
///
/// A sender always sends frames of one length: the first frame sets it, and another length is
/// accepted when it came three times in a row. Until then such frames are rejected as "length".
///
/// Accepts frames of 6 to 32 bytes with command 0x40, of 32 bytes with command 0x00 (Betaflight
/// does not check the command, and its public test frames have 0), and the 31-byte 0x55 variant
/// (docs/protocols/ibus.md, "Variants"). Whether channels 15 to 18 are present is decided for each
/// frame: a value of 0 is not present (docs/protocols/ibus.md, "Channels 15 to 18").
class IbusDecoder final : public ByteDecoder {
  public:
    explicit IbusDecoder(IbusSlots slots = IbusSlots::nibbles) : slots_(slots) {}

    void damaged_byte() override;
    bool silence(DecodedFrame& frame) override;
    void reset() override;
    std::optional<DecodedFrame> finish() override { return std::nullopt; }
    std::span<const NamedCount> rejected() const override { return rejected_; }
    std::uint64_t skipped_bytes() const override { return skipped_bytes_; }

  private:
    static constexpr std::uint16_t kOneOther = 0x100;
    static constexpr std::size_t kLongFrame = 32;
    enum class Kind : std::uint8_t { noise, undecided, servo, ia6, ibus2 };
    struct Candidate {
        Kind kind = Kind::noise;
        std::size_t length = 0;  ///< bytes needed to check it
        bool whole = true;
    };
    /// The bytes that are checked together: frames that begin from `start` on and before `end`.
    struct Window {
        std::span<const std::uint8_t> bytes;
        std::size_t end = 0;
        std::size_t start = 0;
        std::uint64_t damage = 0;  ///< error marks of the first bytes, the first byte in the lowest
                                   ///< bit
    };
    enum class Outcome : std::uint8_t { nothing, wait, frame };
    enum RejectCause : std::size_t { kChecksum, kDamaged, kIbus2, kLength };

    Taken decode(std::span<const std::uint8_t> bytes, Instant received,
                 DecodedFrame& frame) override;
    bool may_begin(std::uint8_t first) const;
    void pass_noise(std::span<const std::uint8_t>& bytes);
    Taken decode_byte(std::span<const std::uint8_t> bytes, Instant received, DecodedFrame& frame);
    Taken decode_pieces(std::span<const std::uint8_t> bytes, Instant received, DecodedFrame& frame);
    bool decode_long(std::span<const std::uint8_t>& bytes, Instant received, DecodedFrame& frame);
    /// `holds`: whether the checksum of a frame of 32 bytes is correct.
    Taken search_last(bool holds, Instant received, DecodedFrame& frame);
    Taken search_kept(std::span<const std::uint8_t> bytes, Instant received, DecodedFrame& frame);
    bool search_instead(bool holds, std::span<const std::uint8_t>& bytes, Instant received,
                        DecodedFrame& frame);
    bool search(std::span<const std::uint8_t>& bytes, std::size_t start, Instant received,
                DecodedFrame& frame);
    Outcome judge(const Window& window, std::span<const std::uint8_t>& read, Instant received,
                  DecodedFrame& frame);
    static Candidate candidate(std::uint8_t begins, std::span<const std::uint8_t> bytes);
    static bool checksum_holds(Kind kind, std::span<const std::uint8_t> frame);
    bool length_counts(std::size_t length);
    Candidate find_frame(std::span<const std::uint8_t> bytes, std::size_t end, std::uint64_t damage,
                         std::size_t& position);
    void begin_frame(std::size_t length, Instant received, DecodedFrame& frame);
    void read_long_frame(std::span<const std::uint8_t, kLongFrame> wire, Instant received,
                         DecodedFrame& frame);
    void read_frame(std::span<const std::uint8_t> wire, std::size_t slots_at, Instant received,
                    DecodedFrame& frame);

    IbusSlots slots_;
    /// Low byte: length of the accepted frames, 0 before the first one. High byte: how many frames
    /// of another length came since. One word, because each accepted frame sets both.
    std::uint16_t usual_length_ = 0;
    std::uint8_t other_length_ = 0;
    /// Whether frames of 32 bytes with nibble channels are accepted without further checks.
    bool long_frames_count_ = slots_ == IbusSlots::nibbles;
    std::array<NamedCount, 4> rejected_{{{"checksum"}, {"damaged"}, {"ibus2"}, {"length"}}};
    std::uint64_t skipped_bytes_ = 0;
};

/// Writes 32-byte frames of 14 or 18 channels, in whole microseconds, 0 to 4095. An absent channel
/// of 1 to 14 is sent as 1500 us, as receivers do for unused ones (docs/protocols/ibus.md,
/// "Variants"), one of 15 to 18 as not present. i.Bus has no sign for failsafe or frame lost
/// (docs/protocols/ibus.md, "Loss of signal"): the caller decides whether to send. Pure and
/// reentrant.
class IbusEncoder final : public ByteEncoder {
  public:
    explicit IbusEncoder(std::size_t channel_count = 14);
    std::uint32_t needed_channels(const ChannelFrame& frame) const override;
    bool marks_frame_lost() const override { return false; }
    std::size_t write(const ChannelFrame& frame, std::span<std::uint8_t, kLongestSerialFrame> wire,
                      Instant now) override;

  private:
    std::size_t encode_filled(const ChannelFrame& frame,
                              std::span<std::uint8_t, kLongestSerialFrame> wire);

    /// Factor for each slot that moves its nibble of the channel value to the top bits; 0 if the
    /// slot carries none.
    std::array<Lanes, 2> nibble_to_top_{};
};

}  // namespace tribus
