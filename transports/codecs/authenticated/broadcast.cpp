#include "transports/codecs/authenticated/broadcast.h"

#include <algorithm>

#include "transports/codecs/wire_words.h"

namespace tribus::authenticated {
namespace {

constexpr std::size_t kSentNumberAt = 4;
constexpr unsigned kNumberBitsOfMac = 16;
constexpr std::size_t kKeyNumberBytes = 6;

}  // namespace

SnapshotMac& BroadcastMacs::mac_for(std::uint64_t number) {
    const std::uint64_t key_number = number >> kNumberBitsOfMac;
    if (key_number_ != key_number) {
        std::array<std::uint8_t, sizeof key_number> bytes{};
        store_word(bytes.data(), key_number);
        mac_.emplace(keys_, std::span(bytes).first(kKeyNumberBytes));
        key_number_ = key_number;
    }
    return *mac_;
}

bool BroadcastSender::write(const ChannelFrame& channels, SnapshotMessage& message, Instant now) {
    if (numbers_ == nullptr) {
        return false;
    }
    const std::uint64_t number = std::max(numbers_->at(clock_step(now)), numbers_->next());
    if (!numbers_->use(number, kNumbers)) {
        return false;
    }
    const bool preset = channels.received == Instant{};
    emit({.age = preset ? kNotTold : age_steps(now - channels.received)}, channels, message);
    store_word(&message[kSentNumberAt], number);
    const std::span<std::uint8_t> bytes(message);
    std::ranges::copy(macs_.of(number, bytes.first(kSnapshotBodyBytes)),
                      bytes.subspan(kSnapshotBodyBytes).begin());
    return true;
}

BroadcastReceiver::BroadcastReceiver(const Mac& keys, const std::optional<Mac>& old)
    : macs_(keys), old_(old ? std::optional(BroadcastMacs(*old)) : std::nullopt) {}

std::optional<ChannelFrame> BroadcastReceiver::next(std::span<const std::uint8_t> message,
                                                    Instant received) {
    if (message.size() != kSnapshotBytes) {
        return refuse(kNoKey, LinkCause::no_key);
    }
    const std::uint64_t number = load_word(&message[kSentNumberAt]);
    const auto told = message.subspan(kSnapshotBodyBytes);
    const auto body = message.first(kSnapshotBodyBytes);
    if (!macs_.is_right(told, number, body) && !(old_ && old_->is_right(told, number, body))) {
        return refuse(kForged, LinkCause::forged);
    }
    if (numbers_ != nullptr && number < numbers_->next()) {
        return refuse(kReplayed, LinkCause::replayed);
    }
    if (numbers_ == nullptr || !numbers_->use(number, kNumbers)) {
        return refuse(kNotStored, LinkCause::garbled);
    }
    why_refused_ = LinkCause::garbled;
    ChannelFrame frame = parse_channels(message);
    const std::uint16_t age = parse_head(message).age;
    const bool has_age = age != kNotTold || !frame.failsafe;
    frame.received =
        received - delay_of(number, received) - (has_age ? age * kTimeStep : Duration{});
    return frame;
}

std::optional<ChannelFrame> BroadcastReceiver::refuse(Refusal refusal, LinkCause cause) {
    ++rejected_[refusal].count;
    why_refused_ = cause;
    return std::nullopt;
}

/// How much later than the quickest one a snapshot came. The first one by another clock of the
/// sender is taken for the quickest.
Duration BroadcastReceiver::delay_of(std::uint64_t number, Instant received) {
    if (quickest_ && number - quickest_->number < kNewClockNumbers) {
        const Duration told = static_cast<std::int64_t>(number - quickest_->number) * kTimeStep;
        const Duration passed = received - quickest_->received;
        const Duration delay = passed - told - passed / kDriftParts;
        if (delay > Duration{}) {
            return delay;
        }
    }
    quickest_ = {number, received};
    return {};
}

}  // namespace tribus::authenticated
