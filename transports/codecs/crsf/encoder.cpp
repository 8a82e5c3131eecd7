#include <algorithm>
#include <array>

#include "transports/codecs/crc8_d5.h"
#include "transports/codecs/crsf/crsf.h"
#include "transports/codecs/crsf/wire.h"

namespace tribus {

using namespace crsf_wire;

namespace {

/// Writes all but the payload, which is there. Returns the length of the frame.
template <std::size_t payload_bytes>
std::size_t finish_frame(std::uint8_t type, std::span<std::uint8_t> wire) {
    wire[0] = kFlightController;
    wire[kLengthAt] = static_cast<std::uint8_t>(payload_bytes + kTypeAndCheck);
    wire[kTypeAt] = type;
    constexpr std::size_t kCheckAt = kPayloadAt + payload_bytes;
    const std::span<const std::uint8_t> bytes = wire;
    wire[kCheckAt] = crc8_d5(bytes.subspan<kTypeAt, kCheckAt - kTypeAt>());
    return kCheckAt + 1;
}

std::size_t write_statistics(std::uint8_t link_quality, std::span<std::uint8_t> wire) {
    constexpr std::size_t kUplinkQualityAt = kPayloadAt + 2;
    std::fill_n(wire.begin() + kPayloadAt, kStatisticsBytes, std::uint8_t{0});
    wire[kUplinkQualityAt] = link_quality;
    return finish_frame<kStatisticsBytes>(kStatisticsType, wire);
}

}  // namespace

std::uint32_t CrsfEncoder::needed_channels(const ChannelFrame& /*frame*/) const {
    return first_channels(kSbusChannels);
}

std::size_t CrsfEncoder::write(const ChannelFrame& frame,
                               std::span<std::uint8_t, kLongestSerialFrame> wire, Instant now) {
    SbusRaw raw;
    if (frame.has_first(kSbusChannels)) {
        raw = scale_.encode_whole(frame);
    } else {
        ChannelFrame filled = frame;
        for (std::size_t channel = 0; channel < kSbusChannels; ++channel) {
            filled.set(channel, frame.channel_or(channel, kCentrePulse));
        }
        raw = scale_.encode_whole(filled);
    }
    pack_channels(raw, 0, wire.subspan<kPayloadAt, kPackedChannelBytes + 1>());
    std::size_t length = finish_frame<kPackedChannelBytes>(kChannelsType, wire);
    if (frame.link_quality != kNoLinkQuality && statistics_due(now)) {
        // Held and preset values have no other mark.
        length += write_statistics(frame.good() ? frame.link_quality : 0, wire.subspan(length));
    }
    return length;
}

std::size_t CrsfEncoder::write_silence(std::span<std::uint8_t, kLongestSerialFrame> wire,
                                       Instant now) {
    return statistics_due(now) ? write_statistics(0, wire) : 0;
}

/// Returns whether statistics are to be written now.
bool CrsfEncoder::statistics_due(Instant now) {
    const bool due = !statistics_at_ || now - *statistics_at_ >= kStatisticsPeriod;
    if (due) {
        statistics_at_ = now;
    }
    return due;
}

}  // namespace tribus
