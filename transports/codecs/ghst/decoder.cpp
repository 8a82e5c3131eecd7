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
    constexpr std::uint64_t kMask = kGhstFineMost;
    return (packed & kMask) | (packed & kMask << 12U) << 4U | (packed & kMask << 24U) << 8U |
           (packed & kMask << 36U) << 12U;
}

/// Four raw values of 8 bits.
GhstFour spread_coarse(std::uint32_t packed) {
    const std::uint64_t pairs = (packed | std::uint64_t{packed} << 16U) & 0x0000'FFFF'0000'FFFF;
    return (pairs | pairs << 8U) & kEachOfFour * 0xFF;
}

std::uint32_t coarse_bytes(const std::uint8_t* frame) {
    constexpr std::size_t kWordAt = kGhstFrameBytes - sizeof(std::uint64_t);
    return static_cast<std::uint32_t>(load_word(frame + kWordAt) >> 8 * (kGhstCoarseAt - kWordAt));
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

GhstFour coarse_eighths(std::uint8_t type, GhstFour raw) {
    constexpr GhstFour kOldOffset = 880 * 8;
    constexpr GhstFour kOldStep = 5 * 8;
    return ghst_scale_of(type) == kGhstNewTypes
               ? raw * kGhstCoarseStepEighths + kEachOfFour * kGhstLeastEighths
               : raw * kOldStep + kEachOfFour * kOldOffset;
}

void store_ghst_pulses(GhstFour eighths, void* pulses) {
    static_assert(std::endian::native == std::endian::little);
    std::memcpy(pulses, &eighths, sizeof eighths);
}

void copy_ghst_pulses(void* to, const std::array<Pulse, kGhstChannels>& pulses) {
    std::memcpy(to, pulses.data(), sizeof pulses);
}

/// All channels are present.
constexpr ChannelFrame kAllGhstChannels = [] {
    ChannelFrame frame;
    frame.frame_lost = false;
    frame.failsafe = false;
    for (std::size_t channel = 0; channel < kGhstChannels; ++channel) {
        frame.set(channel, Pulse{});
    }
    return frame;
}();

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

[[gnu::flatten]] GhstDecoder::Taken GhstDecoder::decode(std::span<const std::uint8_t> bytes,
                                                        Instant received, DecodedFrame& frame) {
    // The usual case, channels in one read. The general way gives the same.
    if (buffer_.size() == 0 && bytes.size() >= kGhstFrameBytes && bytes[0] == kGhstAddress &&
        bytes[kGhstLengthAt] == kGhstLength && has_ghst_channels(bytes[kGhstTypeAt]) &&
        Crc8D5::of(0, bytes.subspan<kGhstTypeAt, kGhstCheckedBytes>()) == bytes[kGhstCheckAt]) {
        frame.first_byte = buffer_.first_position();
        frame.length = kGhstFrameBytes;
        frame.channels.received = received;
        read_channels(bytes.data(), frame.channels);
        buffer_.pass(kGhstFrameBytes);
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
    read_channels(frame.data(), channels);
    return true;
}

/// The arrival in `channels` is set.
void GhstDecoder::read_channels(const std::uint8_t* frame, ChannelFrame& channels) {
    const Instant received = channels.received;
    const std::uint8_t type = frame[kGhstTypeAt];
    const std::size_t content = ghst_content_of(type);
    std::memcpy(latest_.data(), frame + kGhstTypeAt, latest_.size());
    store_ghst_pulses(fine_eighths(type, spread_fine(load_word(frame + kGhstFineAt))),
                      pulses_.data());
    if (content < kGhstGroups) {
        store_ghst_pulses(coarse_eighths(type, spread_coarse(coarse_bytes(frame))),
                          &pulses_[kGhstFineChannels + content * kGhstGroupChannels]);
        group_received_[content] = received;
    } else if (content == kGhstStatisticsContent) {
        take_statistics(frame, received);
    }
    channels = kAllGhstChannels;
    copy_ghst_pulses(&channels.pulses()[0], pulses_);
    channels.received = received;
    remove_old_groups(channels);
    if (statistics_ && received - statistics_->received <= kStatisticsLast) {
        channels.link_quality = statistics_->link_quality;
    }
}

/// Not inline, so that other frames save no registers for it.
[[gnu::noinline]] void GhstDecoder::take_statistics(const std::uint8_t* frame, Instant received) {
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

void GhstDecoder::remove_old_groups(ChannelFrame& channels) const {
    const Instant oldest = *std::ranges::min_element(group_received_);
    if (channels.received - oldest <= kGroupLasts) {
        return;
    }
    constexpr std::uint32_t kFirstGroup = ((1U << kGhstGroupChannels) - 1) << kGhstFineChannels;
    for (std::size_t group = 0; group < kGhstGroups; ++group) {
        if (channels.received - group_received_[group] > kGroupLasts) {
            channels.remove_all(kFirstGroup << group * kGhstGroupChannels);
        }
    }
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
