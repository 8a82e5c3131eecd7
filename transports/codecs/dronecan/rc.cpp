#include "transports/codecs/dronecan/rc.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <utility>

#include "core/rounding.h"
#include "transports/codecs/dronecan/payload.h"

namespace tribus::dronecan {
namespace {

constexpr std::string_view kPercent = "%";
/// A pulse may stand for a share: many receivers send the signal strength in a channel.
constexpr std::string_view kPulseUnit = "us";
constexpr std::uint8_t kMostLinkQuality = 100;
constexpr double kMostRssi = 255;
/// Lifetime of a link quality, for senders that send several kinds in turn.
constexpr Duration kQualityLasts = std::chrono::seconds(1);
constexpr double kSbusCentre = 992;
constexpr double kMicrosecondsPerSbusStep = 0.625;

/// Nothing for the kinds that are not a share of a full signal.
std::optional<double> percent_of(const RcInput& message) {
    constexpr std::uint8_t kLinkQualityBits = 0x7F;  // the other bit is the antenna
    switch (message.status & RcInput::kQualityTypeMask) {
        case RcInput::kQualityTypeRssi:
            return kMostLinkQuality * message.quality / kMostRssi;
        case RcInput::kQualityTypeLinkQuality:
            return message.quality & kLinkQualityBits;
        default:
            return std::nullopt;
    }
}

/// Converts a number from the unit of its kind to the encoding of the message.
double encoded_quality(std::uint16_t type, double number) {
    constexpr double kSnrOffset = 128;
    constexpr double kMilliwattsPerStep = 5;
    switch (type) {
        case RcInput::kQualityTypeRssiDbm:
            return -number;
        case RcInput::kQualityTypeSnr:
            return number + kSnrOffset;
        case RcInput::kQualityTypeTxPower:
            return number / kMilliwattsPerStep;
        case RcInput::kQualityTypeRssi:
            return kMostRssi * number / kMostLinkQuality;
        default:
            return number;
    }
}

}  // namespace

std::string_view unit_of_quality(std::uint16_t type) {
    switch (type) {
        case RcInput::kQualityTypeRssiDbm:
            return "dBm";
        case RcInput::kQualityTypeSnr:
            return "dB";
        case RcInput::kQualityTypeTxPower:
            return "mW";
        default:
            return kPercent;
    }
}

RcDecoder::RcDecoder(RcInputFormat format)
    : format_(format),
      wanted_(ids_of(TransferKind::message, RcInput::kId)),
      source_(format.source),
      receiver_({wanted_transfer<RcInput>()}, format.source.node ? 1 : kMostCandidates),
      details_{{{"source_node", {&detail_values_[0], 1}},
                {"quality", {&detail_values_[1], 1}},
                {"quality_type", {&detail_values_[2], 1}}}} {}

std::optional<ChannelFrame> RcDecoder::next(const CanFrame& frame, Instant received) {
    const auto head = wanted_.matches(frame) ? head_of(frame) : std::nullopt;
    if (!head) {
        return std::nullopt;
    }
    if (!source_.would_accept(head->source, received)) {
        rejected_.count_other_source();
        return std::nullopt;
    }
    const auto taken = receiver_.take(frame, received);
    rejected_.count(taken);
    if (!taken.transfer) {
        return std::nullopt;
    }
    const auto message = read<RcInput>(taken.transfer->payload, taken.transfer->fd);
    if (!message) {
        rejected_.count_layout();
        return std::nullopt;
    }
    if (!accepts(*message, *taken.transfer)) {
        return std::nullopt;
    }
    detail_values_ = {head->source, message->quality,
                      static_cast<std::uint16_t>(message->status & RcInput::kQualityTypeMask)};
    return channels_of(*message, taken.transfer->first_at);
}

bool RcDecoder::accepts(const RcInput& message, const ReceivedTransfer& transfer) {
    const NodeId source = transfer.head.source;
    bool of_source = !format_.receiver || message.id == *format_.receiver;
    // Messages without channels do not select a source.
    if (of_source && !message.rcin.empty()) {
        of_source = source_.accepts(source, transfer.first_at);
    }
    // All receivers of a node share one transfer id.
    const bool in_order = source != source_.current() ||
                          order_.take(transfer.head.transfer_id, true, transfer.first_at) ==
                              CounterWatch::Verdict::good;
    if (!of_source) {
        rejected_.count_other_source();
    } else if (!in_order) {
        rejected_.count_counter_jump();
    }
    return of_source && in_order;
}

ChannelFrame RcDecoder::channels_of(const RcInput& message, Instant at) {
    note_quality(message, at);
    ChannelFrame frame;
    frame.origin = Origin::dronecan;
    frame.received = at;
    frame.failsafe = (message.status & RcInput::kFailsafe) != 0;
    frame.frame_lost = link_quality_ == 0;
    frame.link_quality = link_quality_;
    const std::size_t count = std::min(message.rcin.size(), kChannelCount);
    for (std::size_t channel = 0; channel < count; ++channel) {
        frame.set(channel, pulse_of(message.rcin[channel]));
    }
    return frame;
}

void RcDecoder::note_quality(const RcInput& message, Instant at) {
    const bool valid = (message.status & RcInput::kQualityValid) != 0;
    const auto percent = valid ? percent_of(message) : std::nullopt;
    if (percent) {
        link_quality_ = static_cast<std::uint8_t>(std::clamp<std::int64_t>(
            nearest_whole(*percent), message.quality == 0 ? 0 : 1, kMostLinkQuality));
        link_quality_at_ = at;
    } else if (!valid || at - link_quality_at_ > kQualityLasts) {
        link_quality_ = kNoLinkQuality;
    }
}

Pulse RcDecoder::pulse_of(std::uint16_t raw) const {
    constexpr double kCentre = 1500;
    constexpr double kLow = 1000;
    constexpr double kSpan = 1000;
    constexpr double kMostRaw = 4095;
    switch (format_.scale) {
        case RcScale::sbus:
            return Pulse::from_fractional_microseconds(kCentre + (raw - kSbusCentre) *
                                                                     kMicrosecondsPerSbusStep);
        case RcScale::full_range:
            return Pulse::from_fractional_microseconds(kLow + kSpan * raw / kMostRaw);
        case RcScale::microseconds:
            break;
    }
    return Pulse::from_microseconds(raw);
}

void RcEncoder::use(const ValueBoard& board) {
    value_.find(board, format_.quality_value, "");
    const std::string_view unit = unit_of_quality(format_.quality_type);
    if (value_.own_unit() != kPulseUnit || unit != kPercent) {
        value_.find(board, format_.quality_value, unit);
    }
}

void RcEncoder::continue_from(const Encoder& before) {
    const auto* same = dynamic_cast<const RcEncoder*>(&before);
    if (same != nullptr) {
        transfer_id_ = same->transfer_id_;
        good_ones_ = same->good_ones_;
        latest_sequence_ = same->latest_sequence_;
    }
}

std::uint32_t RcEncoder::needed_channels(const ChannelFrame& snapshot) const {
    const std::uint32_t sent = ~snapshot.absent() & ((1U << format_.channels) - 1);
    return (1U << std::bit_width(sent)) - 1;
}

std::size_t RcEncoder::write(const ChannelFrame& snapshot,
                             std::span<CanFrame, kMostSnapshotFrames> frames, Instant now) {
    if (identity_->id == kNobody) {
        return 0;
    }
    RcInput message;
    message.id = format_.receiver;
    if (snapshot.failsafe) {
        message.status = RcInput::kFailsafe;
    } else {
        write_quality(snapshot, now, message);
    }
    std::size_t count = 0;
    for (std::size_t channel = 0; channel < format_.channels; ++channel) {
        count = snapshot.has(channel) ? channel + 1 : count;
    }
    for (std::size_t channel = 0; channel < count; ++channel) {
        constexpr std::int32_t kMost = 4095;
        message.rcin.push_back(static_cast<std::uint16_t>(
            std::clamp(snapshot.channel_or(channel, kCentrePulse).whole_microseconds(), 0, kMost)));
    }
    const auto payload = dronecan::write(message, format_.fd);
    const TransferHead head{.kind = TransferKind::message,
                            .data_type_id = RcInput::kId,
                            .source = identity_->id,
                            .priority = RcOutputFormat::kPriority,
                            .transfer_id = transfer_id_};
    transfer_id_ = (transfer_id_ + 1) & kMostTransferId;
    return encode_transfer(head, RcInput::kSignature, payload, format_.fd, frames);
}

void RcEncoder::write_quality(const ChannelFrame& snapshot, Instant now, RcInput& message) {
    if (snapshot.frame_lost) {
        share_of_good(snapshot);
        message.status = RcInput::kQualityValid | RcInput::kQualityTypeLinkQuality;
        message.quality = 0;
        return;
    }
    const auto number = quality_of(snapshot, now);
    if (!number) {
        return;
    }
    const auto quality =
        nearest_whole(std::clamp(encoded_quality(format_.quality_type, *number), 0.0, kMostRssi));
    // Some readers take a valid 0 of any kind as "lost", so a good link is never sent as 0.
    message.quality = static_cast<std::uint8_t>(std::max<std::int64_t>(quality, 1));
    message.status = RcInput::kQualityValid | format_.quality_type;
}

/// In percent, or in the unit of the kind of quality.
std::optional<double> RcEncoder::quality_of(const ChannelFrame& snapshot, Instant now) {
    switch (format_.quality) {
        case RcQuality::none:
            break;
        case RcQuality::link: {
            const double share = share_of_good(snapshot);
            return snapshot.link_quality == kNoLinkQuality ? share : snapshot.link_quality;
        }
        case RcQuality::value:
            if (const auto number = value_.fresh(now)) {
                constexpr double kLow = 1000;
                constexpr double kPulsePerPercent = 10;
                return value_.own_unit() == kPulseUnit
                           ? std::clamp((*number - kLow) / kPulsePerPercent, 0.0, 100.0)
                           : number;
            }
            break;
    }
    return std::nullopt;
}

/// Percentage of good ones among the latest frames of the input.
double RcEncoder::share_of_good(const ChannelFrame& snapshot) {
    if (snapshot.sequence != latest_sequence_) {
        latest_sequence_ = snapshot.sequence;
        good_ones_ = good_ones_ << 1U | (snapshot.frame_lost ? 0U : 1U);
    }
    return kMostLinkQuality * static_cast<double>(std::popcount(good_ones_)) / kJudgedFrames;
}

}  // namespace tribus::dronecan
