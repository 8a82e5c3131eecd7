#include <algorithm>

#include "transports/codecs/crsf/crsf.h"
#include "transports/codecs/crsf/wire.h"
#include "transports/codecs/crsf/write.h"

namespace tribus {

using namespace crsf_wire;

namespace {

std::size_t write_statistics(std::uint8_t link_quality, std::span<std::uint8_t> wire) {
    constexpr std::size_t kUplinkQualityAt = kPayloadAt + 2;
    std::fill_n(wire.begin() + kPayloadAt, kStatisticsBytes, std::uint8_t{0});
    wire[kUplinkQualityAt] = link_quality;
    return finish_frame<kStatisticsBytes>(kFlightController, kStatisticsType, wire);
}

}  // namespace

std::uint32_t CrsfEncoder::needed_channels(const ChannelFrame& /*frame*/) const {
    return first_channels(kSbusChannels);
}

std::size_t CrsfEncoder::write(const ChannelFrame& frame,
                               std::span<std::uint8_t, kLongestSerialFrame> wire, Instant now) {
    std::size_t length = write_channels(frame, scale_, kFlightController, wire);
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
