#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/channel_frame.h"
#include "transports/codecs/codec.h"
#include "transports/codecs/framed_decoder.h"
#include "transports/codecs/protocol.h"
#include "transports/codecs/wire_words.h"

/// FlySky i-BUS2 of AFHDS 3 receivers, by listening (docs/protocols/ibus2.md). One wire carries
/// channels for all devices, commands to one device, and its replies.
namespace tribus {

extern const Protocol kIbus2Protocol;

/// Reads channels. A key frame says how many bits each channel has and how long its step is; it
/// counts until another one comes or the line is unplugged. Channels without a key, or of another
/// length than the key says, become a frame without channels. A channel is absent if the key says
/// that it is not used, or has a type that is not known, and if its value is "keep the last" or
/// "stop", which receivers send while they are in failsafe. Passes over failsafe values, commands
/// and replies.
class Ibus2Decoder final : public FramedDecoder {
  public:
    void reset() override;
    /// The types of the channels by the key.
    std::span<const FrameDetail> details() const override;

  private:
    /// Where the value of a channel is in the packed channels, and what it means.
    struct Place {
        std::uint8_t byte = 0;
        std::uint8_t shift = 0;  ///< of its lowest bit in that byte
        std::uint8_t bits = 0;
        std::int16_t least = 0;         ///< lower ones are no values
        std::int16_t step_eighths = 0;  ///< 0: absent
    };
    struct Key {
        std::array<Place, kChannelCount> channels{};
        std::array<std::uint16_t, kChannelCount> types{};
        /// Of a frame of channels; 0 if no key came yet.
        std::size_t frame_length = 0;
        /// How many channels there are if all have one type of 11 bits, as real receivers send
        /// them; else 0.
        std::size_t alike = 0;
        /// All bits of each channel that is there.
        std::array<SignedLanes, 3> used{};
    };

    Taken decode(std::span<const std::uint8_t> bytes, Instant received,
                 DecodedFrame& frame) override;
    std::size_t needed_bytes(std::span<const std::uint8_t> bytes) const override;
    bool check_holds(std::span<const std::uint8_t> frame) const override;
    bool read(std::span<const std::uint8_t> frame, ChannelFrame& channels) override;

    /// As many bytes as a key says, and some that are read with the last of them.
    using Padded = std::array<std::uint8_t, 48>;
    static Key read_key(std::span<const std::uint8_t> packed);
    static std::size_t alike(const Key& key, std::size_t bits);
    void unpack(std::span<const std::uint8_t> packed, ChannelFrame& channels) const;
    bool unpack_alike(const Padded& padded, ChannelFrame& channels) const;
    void unpack_one(const Padded& padded, std::size_t channel, ChannelFrame& channels) const;

    Key key_;
    mutable std::array<FrameDetail, 1> details_{};
};

}  // namespace tribus
