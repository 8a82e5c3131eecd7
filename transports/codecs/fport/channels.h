#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/channel_frame.h"
#include "transports/codecs/byte_sum.h"
#include "transports/codecs/codec.h"
#include "transports/codecs/sbus/packed_channels.h"
#include "transports/codecs/sbus/scale.h"

namespace tribus {

/// Flags and RSSI behind the channels.
inline constexpr std::size_t kFportTailBytes = 2;
constexpr std::size_t fport_content_bytes(std::size_t channels) {
    constexpr std::size_t kBitsPerChannel = 11;
    return channels * kBitsPerChannel / 8 + kFportTailBytes;
}
/// The usual content, of 16 channels.
inline constexpr std::size_t kFportUsualContent = fport_content_bytes(kSbusChannels);

/// The part of a frame that F.Port and F.Port 2 share: packed channels, flags and RSSI
/// (docs/protocols/fport.md, "Channels"). Thread-bound; no heap.
class FportChannels {
  public:
    explicit FportChannels(SbusScale scale) : scale_(scale) {}

    using Usual = std::span<const std::uint8_t, kFportUsualContent>;

    /// Reads the usual content. Sets everything in `channels` but the arrival.
    void read(Usual content, ChannelFrame& channels);
    /// The same for a content of 8, 16 or 24 channels.
    void read_any(std::span<const std::uint8_t> content, ChannelFrame& channels);

    /// Raw values and RSSI of the latest frame.
    std::span<const FrameDetail> details() const;

  private:
    void set(const SbusLanes& raw, std::uint8_t flags, ChannelFrame& channels) const;

    SbusScale scale_;
    /// Raw values of the latest frame, and its RSSI.
    alignas(Lanes) std::array<std::uint16_t, 2 * kSbusChannels> raw_{};
    std::size_t count_ = 0;
    std::array<std::uint16_t, 1> rssi_{};
    mutable std::array<FrameDetail, 2> details_{};
};

/// Whether the checksum over these bytes, itself included, is right: their sum, with each carry
/// added again, is FF. Such a sum is the remainder by 255, with FF for 0 if any byte is not 0.
inline bool fport_sum_holds(unsigned sum) {
    constexpr unsigned kAllOnes = 0xFF;
    return sum != 0 && sum % kAllOnes == 0;
}

}  // namespace tribus
