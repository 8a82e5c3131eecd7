#include <algorithm>
#include <array>
#include <utility>

#include "transports/codecs/crc8_d5.h"
#include "transports/codecs/crsf/crsf.h"
#include "transports/codecs/crsf/wire.h"
#include "transports/codecs/wire_words.h"

namespace tribus {

using namespace crsf_wire;

namespace {

/// Power of the transmitter by its number in the statistics (docs/protocols/crsf.md, "Statistics").
constexpr std::array<std::uint16_t, 9> kPowersMw{0, 10, 25, 100, 500, 1000, 2000, 250, 50};

/// All channels of the frame are present.
constexpr ChannelFrame kSixteenChannels = [] {
    ChannelFrame frame;
    frame.frame_lost = false;
    frame.failsafe = false;
    for (std::size_t channel = 0; channel < kSbusChannels; ++channel) {
        frame.set(channel, Pulse{});
    }
    return frame;
}();

int signed_byte(std::uint8_t byte) {
    return static_cast<std::int8_t>(byte);
}

RadioStatistics read_statistics(std::span<const std::uint8_t> payload, Instant received) {
    constexpr std::size_t kLinkQualityAt = 2;
    constexpr std::size_t kSnrAt = 3;
    constexpr std::size_t kAntennaAt = 4;
    constexpr std::size_t kModeAt = 5;
    constexpr std::size_t kPowerAt = 6;
    const std::size_t power = payload[kPowerAt];
    return {.link_quality = payload[kLinkQualityAt],
            .rssi_dbm = -int{payload[payload[kAntennaAt] == 1 ? 1 : 0]},
            .snr_db = signed_byte(payload[kSnrAt]),
            .power_mw = power < kPowersMw.size() ? std::optional(kPowersMw[power]) : std::nullopt,
            .mode = payload[kModeAt],
            .received = received};
}

RadioStatistics read_receiver_statistics(std::span<const std::uint8_t> payload, Instant received) {
    constexpr std::size_t kLinkQualityAt = 2;
    constexpr std::size_t kSnrAt = 3;
    return {.link_quality = payload[kLinkQualityAt],
            .rssi_dbm = -int{payload[0]},
            .snr_db = signed_byte(payload[kSnrAt]),
            .received = received};
}

}  // namespace

CrsfDecoder::Taken CrsfDecoder::decode(std::span<const std::uint8_t> bytes, Instant received,
                                       DecodedFrame& frame) {
    // The usual case, channels with the usual address and length in one read. The general way gives
    // the same.
    if (buffer_.size() == 0 && bytes.size() >= kChannelsFrameBytes &&
        (load_half_word(bytes.data()) & kHeadBits) == channels_head(kFlightController) &&
        crc8_d5_remainder(bytes.subspan<kTypeAt, kCrc8D5FoldedBytes>()) == 0) {
        frame.first_byte = buffer_.first_position();
        frame.length = kChannelsFrameBytes;
        frame.channels.received = received;
        read_channels(bytes.subspan<kPayloadAt, kPackedChannelBytes>(), frame.channels);
        buffer_.pass(kChannelsFrameBytes);
        return {kChannelsFrameBytes, true};
    }
    return FramedDecoder::decode(bytes, received, frame);
}

bool CrsfDecoder::read(std::span<const std::uint8_t> frame, ChannelFrame& channels) {
    const auto payload = payload_of(frame);
    switch (frame[kTypeAt]) {
        case kChannelsType:
            read_channels(payload.first<kPackedChannelBytes>(), channels);
            return true;
        case kSubsetType:
            return read_subset(payload, channels);
        case kStatisticsType:
            return judge(read_statistics(payload, channels.received), channels);
        case kReceiverStatisticsType:
            return judge(read_receiver_statistics(payload, channels.received), channels);
        default:
            return false;
    }
}

inline void CrsfDecoder::read_channels(std::span<const std::uint8_t, kPackedChannelBytes> packed,
                                       ChannelFrame& channels) {
    const SbusLanes raw = unpack_channels(packed);
    raw_ = from_lanes(raw);
    raw_is_latest_ = true;
    raw_since_subset_ = true;
    const Instant received = channels.received;
    raw_received_ = received;
    channels = kSixteenChannels;
    channels.received = received;
    scale_.decode_whole(raw, channels);
    channels_came(channels);
}

/// The first byte: the number of the first channel (5 bits), the bits of a channel (2 bits: 10 to
/// 13), and whether the channels are only on or off, which nobody sends.
bool CrsfDecoder::read_subset(std::span<const std::uint8_t> payload, ChannelFrame& channels) {
    constexpr unsigned kFirstChannel = 0x1F;
    constexpr unsigned kDigital = 0x80;
    constexpr std::int32_t kOffsetEighths = 988 * 8;
    const unsigned configuration = payload[0];
    if ((configuration & kDigital) != 0) {
        return false;
    }
    const unsigned fineness = configuration >> 5U & 3U;
    const unsigned bits_a_channel = 10 + fineness;
    const std::int32_t step_eighths = 8 >> fineness;
    if (std::exchange(raw_since_subset_, false)) {
        std::ranges::fill(std::span(subset_).first<kSbusChannels>(), SubsetChannel{});
    }
    std::size_t channel = configuration & kFirstChannel;
    std::uint32_t bits = 0;
    unsigned count = 0;
    for (const std::uint8_t byte : payload.subspan(1)) {
        bits |= std::uint32_t{byte} << count;
        count += 8;
        if (count >= bits_a_channel) {
            const auto raw = static_cast<std::int32_t>(bits & ((1U << bits_a_channel) - 1));
            bits >>= bits_a_channel;
            count -= bits_a_channel;
            if (channel < kChannelCount) {
                subset_[channel] = {Pulse::from_eighths(kOffsetEighths + raw * step_eighths),
                                    channels.received, true};
            }
            ++channel;
        }
    }
    fill_subset(channels);
    raw_is_latest_ = false;
    channels_came(channels);
    return channels.has_any();
}

/// The newest value of each channel, in a frame of either type.
void CrsfDecoder::fill_subset(ChannelFrame& channels) const {
    const Instant since = channels.received - kSubsetLasts;
    for (std::size_t i = 0; i < kChannelCount; ++i) {
        const SubsetChannel& own = subset_[i];
        const bool in_whole = i < kSbusChannels && raw_received_ >= since;
        if (own.known && own.received >= since) {
            channels.set(i, own.pulse);
        } else if (in_whole) {
            channels.set(i, scale_.decode(raw_[i]));
        }
    }
}

inline void CrsfDecoder::channels_came(ChannelFrame& channels) {
    channels_at_ = channels.received;
    channels_since_statistics_ = true;
    if (statistics_ && channels.received - statistics_->received <= kStatisticsLast) {
        channels.link_quality = std::min<std::uint8_t>(statistics_->link_quality, 100);
    }
}

/// Returns whether the statistics say that there are no channels.
bool CrsfDecoder::judge(const RadioStatistics& statistics, ChannelFrame& channels) {
    raw_is_latest_ = false;
    channels_at_ = channels_at_.value_or(statistics.received);
    statistics_ = statistics;
    channels.link_quality = std::min<std::uint8_t>(statistics.link_quality, 100);
    const bool channels_came = std::exchange(channels_since_statistics_, false);
    if (!channels_came && statistics.link_quality == 0) {
        channels.failsafe = true;
        return true;
    }
    return !channels_came && statistics.received - *channels_at_ >= kNoChannelsAfter;
}

std::span<const FrameDetail> CrsfDecoder::details() const {
    std::size_t count = 0;
    if (raw_is_latest_) {
        details_[count++] = {"raw", raw_, true};
    }
    if (statistics_) {
        detail_values_ = {statistics_->link_quality,
                          static_cast<std::uint16_t>(-statistics_->rssi_dbm.value_or(0))};
        details_[count++] = {"link_quality", std::span(detail_values_).first(1), false};
        details_[count++] = {"rssi_minus_dbm", std::span(detail_values_).last(1), false};
    }
    return std::span(details_).first(count);
}

}  // namespace tribus
