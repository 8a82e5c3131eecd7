#include <algorithm>
#include <array>

#include "transports/codecs/crc8_d5.h"
#include "transports/codecs/ghst/ghst.h"
#include "transports/codecs/ghst/wire.h"
#include "transports/codecs/wire_words.h"

namespace tribus {

using namespace ghst_wire;

namespace {

/// Readers show less than this as a full signal (Betaflight) or as none (ArduPilot).
constexpr std::uint8_t kGhstLeastRssi = 117;
/// The mode "Pure Race", 250 Hz: readers send no telemetry in it. Zero would be no mode, with which
/// Betaflight takes no channels.
constexpr std::uint8_t kModeWithoutTelemetry = 7;

using GhstRaws = std::array<std::uint16_t, 4>;

/// The nearest raw values of four channels, which are present.
template <int step_eighths, int most>
GhstRaws ghst_raws_of(const Pulse* pulses) {
    constexpr auto kLeast = static_cast<std::int16_t>(kGhstLeastEighths);
    constexpr auto kMost = static_cast<std::int16_t>(kGhstLeastEighths + most * step_eighths);
    GhstRaws raws;
    for (std::size_t i = 0; i < raws.size(); ++i) {
        const auto eighths = static_cast<std::int16_t>(pulses[i].eighths());
        const std::int16_t inside = std::clamp(eighths, kLeast, kMost);
        raws[i] = static_cast<std::uint16_t>(inside - kLeast + step_eighths / 2) / step_eighths;
    }
    return raws;
}

/// Four raw values of 12 bits, the first one lowest.
std::uint64_t pack_fine(const GhstRaws& raws) {
    std::uint64_t packed = 0;
    for (std::size_t i = 0; i < raws.size(); ++i) {
        packed |= std::uint64_t{raws[i]} << (kGhstFineBits * i);
    }
    return packed;
}

/// Four raw values of 8 bits, the first one lowest.
std::uint32_t pack_coarse(const GhstRaws& raws) {
    std::uint32_t packed = 0;
    for (std::size_t i = 0; i < raws.size(); ++i) {
        packed |= std::uint32_t{raws[i]} << (8 * i);
    }
    return packed;
}

std::array<std::uint8_t, 4> ghst_statistics_of(const ChannelFrame& frame) {
    // Held and preset values have no other mark.
    const bool known = frame.link_quality != kNoLinkQuality && frame.good();
    return {known ? frame.link_quality : std::uint8_t{0}, kGhstLeastRssi, kModeWithoutTelemetry, 0};
}

void write_check(std::span<std::uint8_t, kLongestSerialFrame> wire) {
    const std::span<const std::uint8_t> bytes = wire;
    wire[kGhstCheckAt] = Crc8D5::of(0, bytes.subspan<kGhstTypeAt, kGhstCheckedBytes>());
}

}  // namespace

std::uint32_t GhstEncoder::needed_channels(const ChannelFrame& /*frame*/) const {
    return first_channels(kGhstChannels);
}

std::size_t GhstEncoder::next_content(Instant now) {
    if (next_ == kGhstStatisticsContent) {
        next_ = 0;
        if (!statistics_at_ || now - *statistics_at_ >= kStatisticsPeriod) {
            statistics_at_ = now;
            return kGhstStatisticsContent;
        }
    }
    return next_++;
}

std::size_t GhstEncoder::write(const ChannelFrame& frame,
                               std::span<std::uint8_t, kLongestSerialFrame> wire, Instant now) {
    if (!frame.has_first(kGhstChannels)) {
        ChannelFrame filled = frame;
        for (std::size_t channel = 0; channel < kGhstChannels; ++channel) {
            filled.set(channel, frame.channel_or(channel, kCentrePulse));
        }
        return write(filled, wire, now);
    }
    const std::size_t content = next_content(now);
    const Pulse* const pulses = frame.pulses().data();
    wire[0] = kGhstAddress;
    wire[kGhstLengthAt] = kGhstLength;
    wire[kGhstTypeAt] = static_cast<std::uint8_t>(kGhstNewTypes | content);
    store_word(&wire[kGhstFineAt],
               pack_fine(ghst_raws_of<kGhstFineStepEighths, kGhstFineMost>(pulses)));
    if (content == kGhstStatisticsContent) {
        std::ranges::copy(ghst_statistics_of(frame), wire.begin() + kGhstCoarseAt);
    } else {
        const Pulse* const group = pulses + kGhstFineChannels + content * kGhstGroupChannels;
        store_half_word(&wire[kGhstCoarseAt],
                        pack_coarse(ghst_raws_of<kGhstCoarseStepEighths, kGhstCoarseMost>(group)));
    }
    write_check(wire);
    return kGhstFrameBytes;
}

}  // namespace tribus
