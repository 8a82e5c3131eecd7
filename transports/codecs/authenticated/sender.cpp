#include "transports/codecs/authenticated/sender.h"

#include <algorithm>

namespace tribus::authenticated {
namespace {

std::uint32_t session_from(const RandomSeed& seed) {
    return seed[0] | std::uint32_t{seed[1]} << 8U | std::uint32_t{seed[2]} << 16U;
}

}  // namespace

Sender::Sender(const LinkMacs& macs, const RandomSeed& seed)
    : macs_(macs), random_(seed), session_(session_from(seed)) {}

void Sender::use_seed(const RandomSeed& seed) {
    random_ = Mac(seed);
    session_ = session_from(seed);
}

bool Sender::hear(std::span<const std::uint8_t> message, Instant received) {
    if (message.size() != kChallengeBytes ||
        !macs_.challenge.is_right(message.subspan(kChallengeBodyBytes), session_bytes(session_),
                                  message.first(kChallengeBodyBytes))) {
        return false;
    }
    const Challenge heard = parse_challenge(message);
    // Another life is a receiver that started again, or a recording of one: nobody starts again
    // while its challenges are heard.
    if (challenge_ && (heard.life == challenge_->life ? heard.number <= challenge_->number
                                                      : received - challenged_ <= kHelloAfter)) {
        return false;
    }
    challenge_ = heard;
    answers_.emplace(macs_.snapshot_keys, answered_bytes(heard.nonce, session_));
    challenged_ = received;
    return true;
}

Duration Sender::pause_behind_hello() {
    const auto word = random_bytes<2>(random_, 'H', hellos_++);
    const std::int64_t of_all = word[0] | std::int64_t{word[1]} << 8U;
    return kHelloPeriod - kHelloJitter + 2 * kHelloJitter * of_all / 0x10000;
}

bool Sender::write_hello(HelloMessage& message, Instant now) {
    const bool challenged = challenge_ && now - challenged_ <= kHelloAfter;
    if (challenged || (next_hello_ && now < *next_hello_)) {
        return false;
    }
    next_hello_ = now + pause_behind_hello();
    emit_hello(session_, message);
    const std::span<std::uint8_t> bytes(message);
    std::ranges::copy(macs_.hello.of(bytes.first(kHelloBodyBytes)),
                      bytes.subspan(kHelloBodyBytes).begin());
    return true;
}

bool Sender::write(const ChannelFrame& channels, SnapshotMessage& message, Instant now) {
    if (!challenge_) {
        return false;
    }
    const std::uint16_t held = held_steps(now - challenged_);
    if (held == kNotTold) {
        return false;
    }
    const bool preset = channels.received == Instant{};
    const std::uint16_t counter = counter_++;
    emit({.session = session_,
          .challenge = static_cast<std::uint8_t>(challenge_->number),
          .held = held,
          .counter = counter,
          .age = preset ? kNotTold : age_steps(now - channels.received)},
         channels, message);
    const std::span<std::uint8_t> bytes(message);
    std::ranges::copy(answers_->of(counter, bytes.first(kSnapshotBodyBytes)),
                      bytes.subspan(kSnapshotBodyBytes).begin());
    return true;
}

}  // namespace tribus::authenticated
