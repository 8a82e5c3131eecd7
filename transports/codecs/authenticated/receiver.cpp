#include "transports/codecs/authenticated/receiver.h"

#include <algorithm>

namespace tribus::authenticated {
namespace {

/// Clocks of two boards differ by less than one part in so many.
constexpr std::int64_t kDriftParts = 1000;

}  // namespace

Receiver::Receiver(const LinkMacs& macs, std::uint32_t life) : macs_(macs), life_(life) {}

void Receiver::challenge(const Nonce& nonce, ChallengeMessage& message, Instant now) {
    const Challenge challenge{.life = life_, .number = asked_count_, .nonce = nonce};
    asked_[asked_count_++ % kMostAsked] = {challenge, now};
    constexpr std::size_t kBodyBytes = kChallengeBytes - kMacBytes;
    emit(challenge, message);
    const std::span<std::uint8_t> bytes(message);
    std::ranges::copy(macs_.challenge.of(bytes.first(kBodyBytes)),
                      bytes.subspan(kBodyBytes).begin());
}

std::optional<ChannelFrame> Receiver::next(std::span<const std::uint8_t> message,
                                           Instant received) {
    if (message.size() != kSnapshotBytes) {
        return refuse(kLength);
    }
    const SnapshotHead head = parse_head(message);
    const Asked* const answered = asked(head.challenge, received);
    if (answered == nullptr) {
        return refuse(kNoChallenge);
    }
    if (!macs_.snapshot.is_right(message.subspan(kSnapshotBodyBytes), answered->challenge.nonce,
                                 message.first(kSnapshotBodyBytes))) {
        return refuse(kForged);
    }
    const Duration exists = received - answered->sent;
    const Duration held = head.held * kTimeStep;
    const Duration drift = exists / kDriftParts + kTimeStep;
    if (head.held == kNotTold || held > exists + drift) {
        return refuse(kImpossible);
    }
    if (const auto fault = fault_of_order(head, answered->challenge.number, received)) {
        return refuse(*fault);
    }
    ChannelFrame frame = parse_channels(message);
    const Instant sent = std::min(answered->sent + held - drift, received);
    frame.received = head.age == kNotTold ? Instant{} : sent - head.age * kTimeStep;
    return frame;
}

std::optional<ChannelFrame> Receiver::refuse(Refusal refusal) {
    ++rejected_[refusal].count;
    return std::nullopt;
}

const Receiver::Asked* Receiver::asked(std::uint8_t number, Instant received) const {
    const std::size_t kept = std::min<std::size_t>(asked_count_, kMostAsked);
    const auto known = std::span(asked_).first(kept);
    const auto found = std::ranges::find_if(known, [&](const Asked& one) {
        return static_cast<std::uint8_t>(one.challenge.number) == number &&
               received - one.sent <= kChallengeLasts;
    });
    return found == known.end() ? nullptr : &*found;
}

std::optional<Receiver::Refusal> Receiver::fault_of_order(const SnapshotHead& head,
                                                          std::uint32_t number, Instant received) {
    if (bound_ && head.session == session_) {
        if (number < number_ || (number == number_ && head.counter <= counter_)) {
            return kReplayed;
        }
    } else if (bound_) {
        if (number >= number_ && received - accepted_ < kSessionSilence) {
            conflict_until_ = received + kSessionSilence;
            return kTwoSenders;
        }
        // A snapshot that an ended sender left on the way answers no newer challenge.
        if (number <= number_) {
            return kReplayed;
        }
    }
    bound_ = true;
    session_ = head.session;
    number_ = number;
    counter_ = head.counter;
    accepted_ = received;
    return received < conflict_until_ ? std::optional(kTwoSenders) : std::nullopt;
}

}  // namespace tribus::authenticated
