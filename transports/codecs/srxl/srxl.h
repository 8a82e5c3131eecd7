#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "core/channel_frame.h"
#include "core/time.h"
#include "transports/codecs/codec.h"
#include "transports/codecs/framed_decoder.h"
#include "transports/codecs/protocol.h"

/// SRXL of Multiplex (versions 1 and 2; JR calls it XBus mode B) and of Spektrum (version 5); not
/// SRXL2, which is another protocol (docs/protocols/srxl.md). A frame: A1, A2 or A5, words with the
/// high byte first, CRC-16 of all before (polynomial 1021, start 0).
namespace tribus {

extern const Protocol kSrxlProtocol;

/// Longest frame, one of version 2.
inline constexpr std::size_t kSrxlMostBytes = 35;

/// Reads versions 1 (12 channels), 2 (16) and 5 (7 words with their channels' numbers). Versions 1
/// and 2 have no mark for failsafe: their receivers are silent. Version 5 has one.
///
/// A channel of version 5 counts for kWordLasts if later frames lack it, and is absent before its
/// first word; frames of another version do not keep it. Channels stay in the order of the wire,
/// where Spektrum's senders have the throttle first.
class SrxlDecoder final : public FramedDecoder {
  public:
    std::span<const FrameDetail> details() const override;

    /// Two frames of 22 ms carry all channels; so the loss of three such pairs costs no channel.
    static constexpr Duration kWordLasts = std::chrono::milliseconds(200);

  private:
    static constexpr std::size_t kMostWords = 16;
    /// Version 5 has 12 channels beside X-Plus.
    static constexpr std::size_t kNumberedChannels = 12;

    Taken decode(std::span<const std::uint8_t> bytes, Instant received,
                 DecodedFrame& frame) override;
    std::size_t needed_bytes(std::span<const std::uint8_t> bytes) const override;
    bool check_holds(std::span<const std::uint8_t> frame) const override;
    bool read(std::span<const std::uint8_t> frame, ChannelFrame& channels) override;

    void read_all(const std::uint8_t* words, std::size_t count, ChannelFrame& channels);
    void read_words(std::span<const std::uint8_t> frame, ChannelFrame& channels);

    /// The latest word of each channel of version 5, and its arrival.
    struct WordChannel {
        Pulse pulse{};
        std::optional<Instant> received;
    };
    std::array<WordChannel, kNumberedChannels> words_{};

    /// The words of the latest frame and its version, for the details.
    std::array<std::uint16_t, kMostWords> raw_{};
    std::size_t raw_count_ = 0;
    std::array<std::uint16_t, 1> version_{};
    mutable std::array<FrameDetail, 2> details_{};
};

/// Writes frames of version 2: 16 channels; an absent one is sent as 1500 us, because the format
/// has no mark for it. Pulses are limited to 800 to 2199.625 us. Nothing in version 2 says
/// failsafe: on loss nothing is sent.
class SrxlEncoder final : public ByteEncoder {
  public:
    bool marks_frame_lost() const override { return false; }
    std::uint32_t needed_channels(const ChannelFrame& frame) const override;
    std::size_t write(const ChannelFrame& frame, std::span<std::uint8_t, kLongestSerialFrame> wire,
                      Instant now) override;
};

}  // namespace tribus
