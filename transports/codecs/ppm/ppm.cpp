#include "transports/codecs/ppm/ppm.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <string_view>

namespace tribus {

using edge_records::EdgeKind;
using edge_records::EdgeRecord;
using edge_records::kFrameGapEighths;
using edge_records::kRecordBytes;

namespace {

enum PpmCause : std::size_t { kEdgeLost, kDistance, kOtherCount };
/// In the order of PpmCause.
constexpr std::array<std::string_view, 3> kPpmCauses{"edge_lost", "distance", "channel_count"};

}  // namespace

PpmDecoder::PpmDecoder(std::size_t median) : FramedDecoder(kPpmCauses), median_(median) {}

void PpmDecoder::reset() {
    FramedDecoder::reset();
    collects_ = false;
    usual_count_ = 0;
    others_ = 0;
    kept_count_ = 0;
}

std::size_t PpmDecoder::needed_bytes(std::span<const std::uint8_t> bytes) const {
    return edge_records::begins_record(bytes[0]) ? kRecordBytes : 0;
}

bool PpmDecoder::check_holds(std::span<const std::uint8_t> frame) const {
    return edge_records::record_of(frame).has_value();
}

/// The frame that is being collected is wrong. What follows counts from the next pause on.
void PpmDecoder::spoil(std::size_t cause) {
    if (collects_) {
        refuse(cause);
    }
    collects_ = false;
}

void PpmDecoder::add_channel(std::uint32_t eighths) {
    const bool fits = eighths >= ppm::kShortestEighths && eighths <= ppm::kLongestEighths;
    if (!fits || count_ == kChannelCount) {
        spoil(kDistance);
    } else if (collects_) {
        pulses_[count_] = Pulse::from_eighths(eighths);
        ++count_;
    }
}

/// Whether the frame has as many channels as those before. A lost edge makes one channel of two;
/// its time may be that of a channel, so only their number tells.
bool PpmDecoder::has_usual_count() {
    if (count_ == usual_count_) {
        others_ = 0;
        return true;
    }
    others_ = count_ == other_count_ ? others_ + 1 : 1;
    other_count_ = count_;
    if (others_ < (usual_count_ == 0 ? ppm::kFramesToBegin : ppm::kFramesToChange)) {
        return false;
    }
    usual_count_ = count_;
    others_ = 0;
    kept_count_ = 0;
    return true;
}

Pulse PpmDecoder::smoothed(std::size_t channel) const {
    std::array<Pulse, ppm::kMostMedian> values{};
    for (std::size_t frame = 0; frame < kept_count_; ++frame) {
        values[frame] = kept_[frame][channel];
    }
    const auto end = values.begin() + static_cast<std::ptrdiff_t>(kept_count_);
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(kept_count_ / 2);
    std::nth_element(values.begin(), middle, end);
    return *middle;
}

/// A pause came. Returns whether the frame before it counts.
bool PpmDecoder::end_frame(ChannelFrame& channels) {
    if (!collects_ || count_ == 0) {
        return false;
    }
    const bool knows_count = usual_count_ != 0;
    if (count_ < ppm::kLeastChannels || !has_usual_count()) {
        if (knows_count) {
            refuse(kOtherCount);
        }
        return false;
    }
    // A middle of frames from before a pause of the sender would be stale.
    if (channels.received - kept_at_ > ppm::kMostMedianPause) {
        kept_count_ = 0;
    }
    kept_at_ = channels.received;
    const std::size_t after = latest_kept_ + 1 < median_ ? latest_kept_ + 1 : 0;
    latest_kept_ = kept_count_ < median_ ? kept_count_ : after;
    kept_count_ = std::min(kept_count_ + 1, median_);
    kept_[latest_kept_] = pulses_;
    for (std::size_t channel = 0; channel < count_; ++channel) {
        channels.set(channel, smoothed(channel));
    }
    return true;
}

bool PpmDecoder::read(std::span<const std::uint8_t> frame, ChannelFrame& channels) {
    const EdgeRecord record = *edge_records::record_of(frame);
    if (record.kind == EdgeKind::edge_after_loss) {
        spoil(kEdgeLost);
        return false;
    }
    if (record.eighths < kFrameGapEighths) {
        if (record.kind == EdgeKind::edge) {
            add_channel(record.eighths);
        }
        return false;
    }
    const bool whole = end_frame(channels);
    collects_ = record.kind == EdgeKind::edge;
    count_ = 0;
    return whole;
}

std::uint32_t PpmEncoder::needed_channels(const ChannelFrame& /*frame*/) const {
    return first_channels(channels_);
}

std::size_t PpmEncoder::write(const ChannelFrame& frame,
                              std::span<std::uint8_t, kLongestSerialFrame> wire, Instant /*now*/) {
    std::size_t length = 0;
    const auto add = [&wire, &length](EdgeKind kind, std::uint32_t eighths) {
        edge_records::put(wire.subspan(length, kRecordBytes), {kind, eighths});
        length += kRecordBytes;
    };
    add(EdgeKind::edge, ppm::kSentPauseEighths);
    for (std::size_t channel = 0; channel < channels_; ++channel) {
        const auto eighths = std::clamp(frame.channel_or(channel, kCentrePulse).eighths(),
                                        static_cast<std::int32_t>(ppm::kShortestEighths),
                                        static_cast<std::int32_t>(ppm::kLongestEighths));
        add(EdgeKind::edge, static_cast<std::uint32_t>(eighths));
    }
    add(EdgeKind::quiet, ppm::kSentPauseEighths);
    return length;
}

std::size_t PpmEncoder::write_silence(std::span<std::uint8_t, kLongestSerialFrame> wire,
                                      Instant /*now*/) {
    edge_records::put(wire.first<kRecordBytes>(), {EdgeKind::quiet, ppm::kSentPauseEighths});
    return kRecordBytes;
}

Duration ppm_period(std::size_t channels) {
    constexpr std::size_t kUsualChannels = 8;
    const std::size_t more = std::max(channels, kUsualChannels) - kUsualChannels;
    return std::chrono::microseconds(22500) + more * std::chrono::microseconds(2500);
}

}  // namespace tribus
