#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "transports/codecs/crc8_d5.h"
#include "transports/codecs/ghst/ghst.h"
#include "transports/codecs/ghst/wire.h"
#include "transports/codecs/wire_words.h"

namespace tribus {

using namespace ghst_wire;

namespace {

/// Four numbers of 16 bits in one word, the first one lowest.
using GhstFour = std::uint64_t;
constexpr GhstFour kEachOfFour = 0x0001'0001'0001'0001;

/// Four raw values of 12 bits.
GhstFour spread_fine(std::uint64_t packed) {
    constexpr std::uint64_t kTwo = 0xFF'FFFF;
    constexpr std::uint64_t kFirstOfTwo = 0x0000'0FFF'0000'0FFF;
    const std::uint64_t pairs = (packed & kTwo) | (packed & kTwo << 24U) << 8U;
    return (pairs & kFirstOfTwo) | (pairs & ~kFirstOfTwo) << 4U;
}

/// Four raw values of 8 bits.
Lanes spread_coarse(std::uint32_t packed) {
    static_assert(std::endian::native == std::endian::little);
    using Bytes [[gnu::vector_size(16)]] = std::uint8_t;
    const auto bytes = reinterpret_cast<Bytes>(GroupLanes{packed, 0});
    return reinterpret_cast<Lanes>(__builtin_shufflevector(bytes, Bytes{}, 0, 16, 1, 17, 2, 18, 3,
                                                           19, 4, 20, 5, 21, 6, 22, 7, 23));
}

/// A step of channels 1 to 4 in the old types is 5/16 us, cut to a quarter as all readers do; one
/// of the other channels is 5 us (docs/protocols/ghst.md, "Channels").
GhstFour fine_eighths(std::uint8_t type, GhstFour raw) {
    constexpr GhstFour kOldOffset = kGhstLeastEighths - 430 * kGhstFineStepEighths;
    constexpr GhstFour kFourteenBits = kEachOfFour * 0x3FFF;
    return ghst_scale_of(type) == kGhstNewTypes
               ? raw * kGhstFineStepEighths + kEachOfFour * kGhstLeastEighths
               : (raw * 5 >> 2U & kFourteenBits) * kGhstFineStepEighths + kEachOfFour * kOldOffset;
}

Lanes coarse_eighths(std::uint8_t type, Lanes raw) {
    constexpr std::uint16_t kOldOffset = 880 * 8;
    constexpr std::uint16_t kOldStep = 5 * 8;
    constexpr auto kStep = static_cast<std::uint16_t>(kGhstCoarseStepEighths);
    constexpr auto kLeast = static_cast<std::uint16_t>(kGhstLeastEighths);
    return ghst_scale_of(type) == kGhstNewTypes ? raw * kStep + kLeast
                                                : raw * kOldStep + kOldOffset;
}

void store_ghst_pulses(GhstFour eighths, void* pulses) {
    static_assert(std::endian::native == std::endian::little);
    std::memcpy(pulses, &eighths, sizeof eighths);
}

std::uint32_t ghst_fine_raw(std::uint64_t packed, std::size_t channel) {
    return static_cast<std::uint32_t>(packed >> (kGhstFineBits * channel)) & kGhstFineMost;
}

/// Whole mW of a power in dBm; nothing above what the number can hold.
std::optional<std::uint16_t> ghst_milliwatts(std::uint8_t byte) {
    constexpr int kMostDbm = 48;
    const int dbm = byte < 0x80 ? byte : byte - 0x100;
    return dbm <= kMostDbm
               ? std::optional(static_cast<std::uint16_t>(std::lround(std::pow(10.0, dbm / 10.0))))
               : std::nullopt;
}

}  // namespace

ChannelFrame GhstDecoder::all_channels() {
    ChannelFrame frame;
    frame.frame_lost = false;
    frame.failsafe = false;
    frame.mark_first(kGhstChannels);
    return frame;
}

GhstDecoder::Taken GhstDecoder::decode(std::span<const std::uint8_t> bytes, Instant received,
                                       DecodedFrame& frame) {
    // The usual case, channels with a group in one read. The general way gives the same.
    if (buffer_.size() == 0 && bytes.size() >= kGhstFrameBytes &&
        begins_with_ghst_group(load_half_word(bytes.data())) &&
        Crc8D5::of(0, bytes.subspan<kGhstTypeAt, kGhstCheckedBytes>()) == bytes[kGhstCheckAt]) {
        frame.first_byte = buffer_.first_position();
        frame.length = kGhstFrameBytes;
        buffer_.pass(kGhstFrameBytes);
        const std::uint8_t type = bytes[kGhstTypeAt];
        keep_fine(bytes.data(), type);
        keep_group(bytes.data(), type, received);
        give(received, frame.channels);
        return {kGhstFrameBytes, true};
    }
    return FramedDecoder::decode(bytes, received, frame);
}

std::size_t GhstDecoder::needed_bytes(std::span<const std::uint8_t> bytes) const {
    const bool begins = bytes[0] == kGhstAddress &&
                        (bytes.size() <= kGhstLengthAt || bytes[kGhstLengthAt] == kGhstLength);
    if (!begins) {
        return 0;
    }
    return bytes.size() <= kGhstLengthAt ? kGhstLengthAt + 1 : kGhstFrameBytes;
}

bool GhstDecoder::check_holds(std::span<const std::uint8_t> frame) const {
    return Crc8D5::of(0, frame.subspan<kGhstTypeAt, kGhstCheckedBytes>()) == frame[kGhstCheckAt];
}

bool GhstDecoder::read(std::span<const std::uint8_t> frame, ChannelFrame& channels) {
    if (!has_ghst_channels(frame[kGhstTypeAt])) {
        return false;
    }
    const Instant received = channels.received;
    const std::uint8_t type = frame[kGhstTypeAt];
    const std::size_t content = ghst_content_of(type);
    keep_fine(frame.data(), type);
    if (content < kGhstGroups) {
        keep_group(frame.data(), type, received);
    } else if (content == kGhstStatisticsContent) {
        take_statistics(frame.data(), received);
    }
    give(received, channels);
    return true;
}

/// Keeps the frame for the details, and its channels 1 to 4. The type is that of the frame; to read
/// it again would cost time.
inline void GhstDecoder::keep_fine(const std::uint8_t* frame, std::uint8_t type) {
    std::memcpy(latest_.data(), frame + kGhstTypeAt, latest_.size());
    store_ghst_pulses(fine_eighths(type, spread_fine(load_word(frame + kGhstFineAt))),
                      &values_.pulses()[0]);
}

inline void GhstDecoder::keep_group(const std::uint8_t* frame, std::uint8_t type,
                                    Instant received) {
    const std::size_t group = ghst_content_of(type);
    store_half_lanes(&values_.pulses()[kGhstFineChannels + group * kGhstGroupChannels],
                     coarse_eighths(type, spread_coarse(load_half_word(frame + kGhstCoarseAt))));
    group_received_[group] = received;
}

inline void GhstDecoder::give(Instant received, ChannelFrame& channels) {
    channels = values_;
    channels.received = received;
    if (statistics_ && received - statistics_->received <= kStatisticsLast) {
        channels.link_quality = statistics_->link_quality;
    }
    if (received > groups_last_until_) {
        remove_old_groups(channels);
    }
}

void GhstDecoder::take_statistics(const std::uint8_t* frame, Instant received) {
    constexpr std::uint8_t kMost = 100;
    // The bits above are flags (ArduPilot: telemetry, other scale).
    constexpr unsigned kModeBits = 0x1F;
    const std::uint8_t quality = frame[kGhstLinkQualityAt];
    statistics_ = {.link_quality = quality <= kMost ? quality : kNoLinkQuality,
                   .rssi_dbm = -int{frame[kGhstRssiAt]},
                   .power_mw = ghst_milliwatts(frame[kGhstPowerAt]),
                   .mode = static_cast<std::uint8_t>(frame[kGhstModeAt] & kModeBits),
                   .received = received};
}

void GhstDecoder::remove_old_groups(ChannelFrame& channels) {
    constexpr std::uint32_t kFirstGroup = ((1U << kGhstGroupChannels) - 1) << kGhstFineChannels;
    for (std::size_t group = 0; group < kGhstGroups; ++group) {
        if (channels.received - group_received_[group] > kGroupLasts) {
            channels.remove_all(kFirstGroup << group * kGhstGroupChannels);
        }
    }
    groups_last_until_ = *std::ranges::min_element(group_received_) + kGroupLasts;
}

std::span<const FrameDetail> GhstDecoder::details() const {
    std::size_t count = 0;
    if (ghst_scale_of(latest_[0]) != 0) {
        const std::size_t content = ghst_content_of(latest_[0]);
        const std::size_t raw =
            content < kGhstGroups ? kGhstFineChannels + kGhstGroupChannels : kGhstFineChannels;
        const std::uint64_t packed = load_word(&latest_[kGhstFineAt - kGhstTypeAt]);
        for (std::size_t i = 0; i < kGhstFineChannels; ++i) {
            detail_values_[1 + i] = static_cast<std::uint16_t>(ghst_fine_raw(packed, i));
            detail_values_[1 + kGhstFineChannels + i] = latest_[kGhstCoarseAt - kGhstTypeAt + i];
        }
        detail_values_[0] = latest_[0];
        details_[count++] = {"type", std::span(detail_values_).first(1), false};
        details_[count++] = {"raw", std::span(detail_values_).subspan(1, raw), true};
    }
    if (statistics_) {
        detail_values_[9] = statistics_->link_quality;
        detail_values_[10] = static_cast<std::uint16_t>(-statistics_->rssi_dbm.value_or(0));
        details_[count++] = {"link_quality", std::span(detail_values_).subspan(9, 1), false};
        details_[count++] = {"rssi_minus_dbm", std::span(detail_values_).subspan(10, 1), false};
    }
    return std::span(details_).first(count);
}

}  // namespace tribus
