#include "pipelines/input.h"

#include <algorithm>
#include <optional>
#include <utility>

namespace tribus {

Input::Input(InputSettings settings, std::uint8_t index)
    : name_(std::move(settings.name)),
      decoder_(std::move(settings.decoder)),
      can_decoder_(std::move(settings.can_decoder)),
      timeout_(settings.timeout),
      failsafe_when_(std::move(settings.failsafe_when)),
      index_(index) {}

bool Input::decode(std::span<const std::uint8_t> bytes, Instant now) {
    bool any = false;
    while (decoder_->next(bytes, now, decoded_)) {
        take(decoded_.channels, now);
        any = true;
    }
    return any;
}

bool Input::receive(const CanFrame& frame, Instant at) {
    if (std::ranges::none_of(wanted_ids(),
                             [&](const CanIdMatch& id) { return id.matches(frame); })) {
        return false;
    }
    counts_.bytes += frame.length;
    const auto snapshot = can_decoder_->next(frame, at);
    if (snapshot) {
        take(*snapshot, at);
    }
    return snapshot.has_value();
}

std::span<const CanIdMatch> Input::wanted_ids() const {
    return can_decoder_ ? can_decoder_->wanted() : std::span<const CanIdMatch>{};
}

const DecoderReport& Input::decoder() const {
    return decoder_ ? static_cast<const DecoderReport&>(*decoder_) : *can_decoder_;
}

bool Input::rule_says_loss(const ChannelFrame& frame) const {
    for (const LossRule& rule : failsafe_when_) {
        const std::optional<Pulse> pulse = frame.channel(rule.channel);
        if (pulse &&
            ((rule.below && *pulse < *rule.below) || (rule.above && *pulse > *rule.above))) {
            return true;
        }
    }
    return false;
}

void Input::take(ChannelFrame frame, Instant now) {
    frame.source = index_;
    frame.sequence = latest_.sequence + 1;
    frame.failsafe = frame.failsafe || rule_says_loss(frame);
    ++counts_.frames;
    arrivals_.arrived(now);
    latest_ = frame;

    if (frame.good()) {
        const bool was_lost = !ever_good_ || failsafe_ || now >= good_.received + timeout_;
        if (was_lost) {
            ++runs_;
        }
        // A frame-lost mark breaks the run that recovery waits for, though the link was not lost.
        if (was_lost || run_broken_) {
            run_start_ = now;
        }
        run_broken_ = false;
        failsafe_ = false;
        ever_good_ = true;
        good_ = frame;
        return;
    }
    run_broken_ = true;
    if (frame.failsafe) {
        ++counts_.failsafe_frames;
        failsafe_since_ = failsafe_ ? failsafe_since_ : now;
        failsafe_ = true;
    } else {
        ++counts_.frame_lost_frames;
        good_.frame_lost = true;
    }
}

}  // namespace tribus
