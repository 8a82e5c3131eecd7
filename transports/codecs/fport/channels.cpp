#include "transports/codecs/fport/channels.h"

#include <algorithm>
#include <cstring>

namespace tribus {
namespace {

constexpr unsigned kFportFrameLost = 0x04;
constexpr unsigned kFportFailsafe = 0x08;
constexpr std::size_t kFportRawBits = 11;

/// The first 16 channels of the frame are present.
constexpr ChannelFrame kSixteenOfFport = [] {
    ChannelFrame frame;
    for (std::size_t channel = 0; channel < kSbusChannels; ++channel) {
        frame.set(channel, Pulse{});
    }
    return frame;
}();

}  // namespace

inline void FportChannels::set(const SbusLanes& raw, std::uint8_t flags,
                               ChannelFrame& channels) const {
    const Instant received = channels.received;
    channels = kSixteenOfFport;
    channels.received = received;
    channels.frame_lost = (flags & kFportFrameLost) != 0;
    channels.failsafe = (flags & kFportFailsafe) != 0;
    if (scale_.whole_steps()) {
        scale_.decode_whole(raw, channels);
    } else {
        scale_.decode_each(from_lanes(raw), channels);
    }
}

void FportChannels::read(Usual content, ChannelFrame& channels) {
    const SbusLanes raw = unpack_channels(content.first<kPackedChannelBytes>());
    std::memcpy(raw_.data(), &raw, sizeof raw);
    count_ = kSbusChannels;
    rssi_[0] = content[kFportUsualContent - 1];
    set(raw, content[kFportUsualContent - kFportTailBytes], channels);
}

void FportChannels::read_any(std::span<const std::uint8_t> content, ChannelFrame& channels) {
    std::array<std::uint8_t, 2 * kPackedChannelBytes> packed{};
    const auto tail = content.last(kFportTailBytes);
    std::copy(content.begin(), content.end() - kFportTailBytes, packed.begin());
    const std::span<const std::uint8_t, packed.size()> all(packed);
    const SbusLanes first = unpack_channels(all.first<kPackedChannelBytes>());
    const SbusLanes rest = unpack_channels(all.last<kPackedChannelBytes>());
    std::memcpy(raw_.data(), &first, sizeof first);
    std::memcpy(&raw_[kSbusChannels], &rest, sizeof rest);
    count_ = (content.size() - kFportTailBytes) * 8 / kFportRawBits;
    rssi_[0] = tail[1];
    set(first, tail[0], channels);
    for (std::size_t channel = count_; channel < kSbusChannels; ++channel) {
        channels.remove(channel);
    }
    for (std::size_t channel = kSbusChannels; channel < std::min(count_, kChannelCount);
         ++channel) {
        channels.set(channel, scale_.decode(raw_[channel]));
    }
}

std::span<const FrameDetail> FportChannels::details() const {
    if (count_ == 0) {
        return {};
    }
    details_ = {{{"raw", std::span(raw_).first(count_), true}, {"rssi", rssi_, false}}};
    return details_;
}

}  // namespace tribus
