#include "transports/codecs/authenticated/broadcast.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "transports/codecs/wire_words.h"

namespace tribus::authenticated {
namespace {

constexpr std::size_t kSentNumberAt = 4;
constexpr unsigned kVersionShift = 4;

std::uint8_t version_of(std::span<const std::uint8_t> message) {
    return message[0] >> kVersionShift;
}

}  // namespace

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
    message[0] = static_cast<std::uint8_t>(message[0] | kBroadcastVersion << kVersionShift);
    store_word(&message[kSentNumberAt], number);
    const std::span<std::uint8_t> bytes(message);
    std::ranges::copy(key_.of(bytes.first(kSnapshotBodyBytes)),
                      bytes.subspan(kSnapshotBodyBytes).begin());
    return true;
}

BroadcastReceiver::Key::Key(const Mac& its_mac) : mac(its_mac) {
    constexpr std::array<std::uint8_t, 1> kIdLetter{'I'};
    id = static_cast<std::uint32_t>(load_word(mac.of(kIdLetter).data()));
}

BroadcastReceiver::BroadcastReceiver(const Mac& key, const std::optional<Mac>& old)
    : key_(key), old_(old ? std::optional(Key(*old)) : std::nullopt) {}

void BroadcastReceiver::use_numbers(NumberReservation& numbers) {
    key_.numbers = &numbers.of_key(key_.id);
    if (old_) {
        old_->numbers = &numbers.of_key(old_->id);
    }
}

/// A key that was not there before has the same sender, so the same clock.
void BroadcastReceiver::use_keys_of(const BroadcastReceiver& fresh) {
    const Key before = key_;
    const std::optional<Key> old_before = old_;
    const auto quickest_of = [&](const Key& key) {
        return old_before && old_before->id == key.id ? old_before->quickest : before.quickest;
    };
    key_ = fresh.key_;
    key_.quickest = quickest_of(key_);
    old_ = fresh.old_;
    if (old_) {
        old_->quickest = quickest_of(*old_);
    }
}

std::optional<ChannelFrame> BroadcastReceiver::next(std::span<const std::uint8_t> message,
                                                    Instant received) {
    if (message.size() != kSnapshotBytes) {
        return refuse(kNoKey, LinkCause::no_key);
    }
    other_version_ = version_of(message) != kBroadcastVersion;
    if (other_version_) {
        return refuse(kOtherVersion, LinkCause::garbled);
    }
    const std::uint64_t number = load_word(&message[kSentNumberAt]);
    const auto told = message.subspan(kSnapshotBodyBytes);
    const auto body = message.first(kSnapshotBodyBytes);
    const bool by_key = key_.mac.is_right(told, body);
    if (!by_key && !(old_ && old_->mac.is_right(told, body))) {
        return refuse(kForged, LinkCause::forged);
    }
    Key& key = by_key ? key_ : *old_;
    // What the old key proves is from before the change of keys.
    if (number < std::max(key.next(), key_.next()) || number >= kEndOfNumbers) {
        return refuse(kReplayed, LinkCause::replayed);
    }
    if (key.numbers == nullptr || !key.numbers->use(number, kNumbers)) {
        return refuse(kNotStored, LinkCause::garbled);
    }
    why_refused_ = LinkCause::garbled;
    ChannelFrame frame = parse_channels(message);
    const std::uint16_t age = parse_head(message).age;
    const bool has_age = age != kNotTold || !frame.failsafe;
    frame.received =
        received - key.delay_of(number, received) - (has_age ? age * kTimeStep : Duration{});
    return frame;
}

std::optional<ChannelFrame> BroadcastReceiver::refuse(Refusal refusal, LinkCause cause) {
    ++rejected_[refusal].count;
    why_refused_ = cause;
    return std::nullopt;
}

std::size_t BroadcastReceiver::write_fault(std::span<char> text) const {
    constexpr std::string_view kOther =
        "snapshots of another version of tribus; give both ends the same one";
    return other_version_ ? kOther.copy(text.data(), text.size()) : 0;
}

/// How much later than the quickest one a snapshot came. The first one by another clock of the
/// sender is taken for the quickest.
Duration BroadcastReceiver::Key::delay_of(std::uint64_t number, Instant received) {
    if (quickest && number - quickest->number < kNewClockNumbers) {
        const Duration told = static_cast<std::int64_t>(number - quickest->number) * kTimeStep;
        const Duration passed = received - quickest->received;
        const Duration delay = passed - told - passed / kDriftParts;
        if (delay > Duration{}) {
            return delay;
        }
    }
    quickest = {number, received};
    return {};
}

}  // namespace tribus::authenticated
