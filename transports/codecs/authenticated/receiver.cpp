#include "transports/codecs/authenticated/receiver.h"

#include <algorithm>
#include <bit>

namespace tribus::authenticated {
namespace {

/// Clocks of two boards differ by less than one part in so many.
constexpr std::int64_t kDriftParts = 1000;
/// Half of all values of the counter.
constexpr std::uint16_t kMostAhead = 0x7FFF;

}  // namespace

Receiver::Receiver(const LinkMacs& macs, const std::optional<LinkMacs>& old, const RandomSeed& seed)
    : key_{macs}, old_(old ? std::optional(Key{*old}) : std::nullopt), random_(seed) {
    answered_sessions_.fill(kSessionMask + 1);
    use_seed(seed);
}

void Receiver::use_seed(const RandomSeed& seed) {
    random_ = Mac(seed);
    key_.answers.reset();
    if (old_) {
        old_->answers.reset();
    }
    life_ = std::bit_cast<std::uint32_t>(random_bytes<sizeof life_>(random_, 'L', 0));
}

void Receiver::use_keys_of(const Receiver& fresh) {
    key_ = fresh.key_;
    old_ = fresh.old_;
    forget_askers();
}

void Receiver::ask_anew(Instant now) {
    const RandomSeed fresh = fresh_ != nullptr ? fresh_() : RandomSeed{};
    const std::span<const std::uint8_t> more(fresh);
    asked_[asked_count_ % kMostAsked] = {
        {.life = life_,
         .number = asked_count_,
         .nonce = random_bytes<std::tuple_size_v<Nonce>>(random_, 'N', asked_count_,
                                                         more.first(fresh_ ? more.size() : 0))},
        now};
    ++asked_count_;
}

void Receiver::wait(const Asker& asker) {
    const auto waiting = std::span(askers_).first(askers_count_);
    const auto same = std::ranges::find_if(waiting, [&](const Asker& one) {
        return one.session == asker.session && one.old_key == asker.old_key;
    });
    if (same != waiting.end()) {
        same->rank = std::max(same->rank, asker.rank);
    } else if (askers_count_ < kMostAskers) {
        askers_[askers_count_++] = asker;
    } else if (const auto last = std::ranges::min_element(askers_, {}, &Asker::rank);
               last->rank <= asker.rank) {
        std::shift_left(last, askers_.end(), 1);
        askers_.back() = asker;
    }
}

bool Receiver::may_answer_hello(Rank rank, Instant now) {
    const Instant paid = std::max(answers_paid_, now) + kAnswerPeriod;
    const int most = rank == Rank::says_hello ? kAnswersAtOnce : kAnswersAtOnce / 2;
    if (paid - now > most * kAnswerPeriod) {
        return false;
    }
    answers_paid_ = paid;
    return true;
}

/// A snapshot that counts is always answered. Of hellos, those of sessions that were not answered
/// lately come first, and of these the latest.
std::optional<Receiver::Asker> Receiver::next_asker(Instant now) {
    const auto waiting = std::span(askers_).first(askers_count_);
    auto first = waiting.begin();
    for (auto one = first; one != waiting.end(); ++one) {
        first = one->rank >= first->rank ? one : first;
    }
    if (first == waiting.end() ||
        (first->rank != Rank::sends_snapshots && !may_answer_hello(first->rank, now))) {
        return std::nullopt;
    }
    const Asker asker = *first;
    std::shift_left(first, waiting.end(), 1);
    --askers_count_;
    if (asker.rank == Rank::says_hello) {
        answered_sessions_[answered_count_++ % kAnsweredLately] = asker.session;
    }
    return asker;
}

/// Who says hello again gets the same challenge again, unless that is old: so nobody who repeats
/// hellos can push the others out.
bool Receiver::answer(ChallengeMessage& message, Instant now) {
    const auto asker = next_asker(now);
    if (!asker) {
        return false;
    }
    if (asked_count_ == 0 || now - newest().sent >= kChallengePeriod) {
        ask_anew(now);
    }
    emit(newest().challenge, message);
    Mac& mac = (asker->old_key ? *old_ : key_).macs.challenge;
    const std::span<std::uint8_t> bytes(message);
    std::ranges::copy(mac.of(session_bytes(asker->session), bytes.first(kChallengeBodyBytes)),
                      bytes.subspan(kChallengeBodyBytes).begin());
    return true;
}

std::optional<ChannelFrame> Receiver::next(std::span<const std::uint8_t> message,
                                           Instant received) {
    if (message.size() == kSnapshotBytes) {
        return take_snapshot(message, received);
    }
    if (message.size() != kHelloBytes) {
        return refuse(kNoKey);
    }
    take_hello(message);
    return std::nullopt;
}

template <class IsRight>
std::optional<bool> Receiver::key_of(const IsRight& is_right) {
    if (is_right(key_)) {
        return false;
    }
    return old_ && is_right(*old_) ? std::optional(true) : std::nullopt;
}

SnapshotMac& Receiver::Key::mac_of_answers(const Challenge& challenge, std::uint32_t session) {
    if (!answers || answers->number != challenge.number || answers->session != session) {
        answers = {challenge.number, session,
                   SnapshotMac(macs.snapshot_keys, answered_bytes(challenge.nonce, session))};
    }
    return answers->mac;
}

void Receiver::take_hello(std::span<const std::uint8_t> message) {
    const auto old_key = key_of([&](Key& key) {
        return key.macs.hello.is_right(message.subspan(kHelloBodyBytes),
                                       message.first(kHelloBodyBytes));
    });
    if (!old_key) {
        refuse(kForged);
        return;
    }
    why_refused_ = LinkCause::garbled;
    const std::uint32_t session = parse_hello(message);
    const bool lately = std::ranges::find(answered_sessions_, session) != answered_sessions_.end();
    wait({session, *old_key, lately ? Rank::answered_lately : Rank::says_hello});
}

std::optional<ChannelFrame> Receiver::take_snapshot(std::span<const std::uint8_t> message,
                                                    Instant received) {
    const SnapshotHead head = parse_head(message);
    const Asked* const answered = asked(head.challenge, received);
    if (answered == nullptr) {
        return refuse(kNoChallenge);
    }
    const auto old_key = key_of([&](Key& key) {
        return key.mac_of_answers(answered->challenge, head.session)
            .is_right(message.subspan(kSnapshotBodyBytes), head.counter,
                      message.first(kSnapshotBodyBytes));
    });
    if (!old_key) {
        return refuse(kForged);
    }
    const Duration exists = received - answered->sent;
    const Duration held = head.held * kTimeStep;
    const Duration drift = exists / kDriftParts + kTimeStep;
    if (head.held == kNotTold || held > exists + drift) {
        return refuse(kImpossible);
    }
    const auto fault = fault_of_order(head, answered->challenge.number, received);
    if ((!fault || fault == kTwoSenders) && exists >= kChallengePeriod) {
        wait({head.session, *old_key, Rank::sends_snapshots});
    }
    if (fault) {
        return refuse(*fault);
    }
    why_refused_ = LinkCause::garbled;
    ChannelFrame frame = parse_channels(message);
    const Instant sent = std::min(answered->sent + held - drift, received);
    // Presets have no age. Of other values it is not told if it is more.
    const bool has_age = head.age != kNotTold || !frame.failsafe;
    frame.received = has_age ? sent - head.age * kTimeStep : sent;
    return frame;
}

std::optional<ChannelFrame> Receiver::refuse(Refusal refusal) {
    ++rejected_[refusal].count;
    why_refused_ = refusal == kNoKey    ? LinkCause::no_key
                   : refusal == kForged ? LinkCause::forged
                                        : LinkCause::replayed;
    return std::nullopt;
}

const Receiver::Asked* Receiver::asked(std::uint8_t number, Instant received) const {
    const Asked& one = asked_[number % kMostAsked];
    const bool known = number % kMostAsked < asked_count_ &&
                       static_cast<std::uint8_t>(one.challenge.number) == number;
    return known && received - one.sent <= kChallengeLasts ? &one : nullptr;
}

std::optional<Receiver::Refusal> Receiver::fault_of_order(const SnapshotHead& head,
                                                          std::uint32_t number, Instant received) {
    if (bound_ && head.session == session_) {
        // What answers a challenge that still counts was sent after the one before if that is older
        // than challenges count. Until then the counter cannot come round.
        const auto ahead = static_cast<std::uint16_t>(head.counter - counter_);
        if (received - accepted_ <= kChallengeLasts && (ahead == 0 || ahead > kMostAhead)) {
            return kReplayed;
        }
    } else if (bound_) {
        // It may have been on the way since before another sender started; that ends soon.
        if (received - accepted_ < kSessionSilence) {
            conflict_until_ = received + kSessionSilence;
            return kTwoSenders;
        }
        // A snapshot that an ended sender left on the way answers no newer challenge.
        if (number <= number_) {
            return kReplayed;
        }
    }
    number_ = bound_ ? std::max(number_, number) : number;
    bound_ = true;
    session_ = head.session;
    counter_ = head.counter;
    accepted_ = received;
    return received < conflict_until_ ? std::optional(kTwoSenders) : std::nullopt;
}

}  // namespace tribus::authenticated
