#include "pipelines/rules/link_supervisor.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <optional>
#include <utility>

namespace tribus {
namespace {

/// Channels 17 and 18 of SBUS are switches without a raw number.
constexpr std::size_t kNumberedChannels = 16;

}  // namespace

LinkSupervisor::LinkSupervisor(SupervisionSettings settings) : settings_(std::move(settings)) {}

void LinkSupervisor::continue_from(LinkSupervisor& before, Instant now) {
    const bool begins_to_watch =
        settings_.frozen > Duration::zero() && before.settings_.frozen == Duration::zero();
    std::swap(*this, before);
    std::swap(settings_, before.settings_);
    if (begins_to_watch) {
        unchanged_ = good_;
        unchanged_since_ = now;
    }
    if (ever_good_) {
        expires_ = not_after_frozen(std::min(expires_, good_.received + settings_.timeout));
    }
}

bool LinkSupervisor::all_zero(const ChannelFrame& frame) const {
    if (!settings_.raw_zero || !frame.has(0)) {
        return false;
    }
    for (std::size_t channel = 0; channel < kNumberedChannels; ++channel) {
        if (frame.channel_or(channel, *settings_.raw_zero) != *settings_.raw_zero) {
            return false;
        }
    }
    return true;
}

bool LinkSupervisor::any_zero(const ChannelFrame& frame) const {
    const auto numbered = std::span(frame.pulses()).first(kNumberedChannels);
    for (std::size_t channel = 0; channel < kNumberedChannels; ++channel) {
        if (numbered[channel] == *settings_.raw_zero && frame.has(channel)) {
            return true;
        }
    }
    return false;
}

bool LinkSupervisor::rule_says_loss(const ChannelFrame& frame) const {
    return std::ranges::any_of(settings_.failsafe_when, [&](const ValueRule& rule) {
        return rule.all_zero ? all_zero(frame) : rule.matches(frame);
    });
}

bool LinkSupervisor::within(const PulseRange& range, const ChannelFrame& frame) {
    if (frame.absent() != absent_) {
        absent_ = frame.absent();
        present_ = present_channels(absent_);
    }
    return all_within(frame, std::bit_cast<std::int16_t>(range.low),
                      std::bit_cast<std::int16_t>(range.high), present_);
}

/// Some receivers clear the failsafe flag before they have channel values again, and send zeros for
/// a while.
bool LinkSupervisor::plausible(const ChannelFrame& frame, Instant now) {
    if (settings_.plausible && !within(*settings_.plausible, frame)) {
        return false;
    }
    if (!settings_.raw_zero || settings_.zero_guard == Duration::zero()) {
        return true;
    }
    const bool lost = !alive(now);
    const bool resumed = ever_frame_ && now - latest_frame_ >= settings_.timeout;
    if (lost && (!guarded_ || resumed)) {
        guarded_ = true;
        guarded_until_ = later(now, settings_.zero_guard);
    }
    const bool within = guarded_ && now < guarded_until_;
    guarded_ = guarded_ && (lost || within);
    return !within || !any_zero(frame);
}

void LinkSupervisor::note_implausible(const ChannelFrame& frame, Instant now) {
    ++implausible_.frames;
    implausible_.at = now;
    const auto note_first = [&](const std::optional<PulseRange>& range, auto is_wrong) {
        for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
            const Pulse pulse = frame.pulses()[channel];
            if (frame.has(channel) && is_wrong(pulse)) {
                implausible_.channel = channel;
                implausible_.pulse = pulse;
                implausible_.plausible = range;
                return true;
            }
        }
        return false;
    };
    const auto& range = settings_.plausible;
    if (!range || !note_first(range, [&](Pulse pulse) { return !range->contains(pulse); })) {
        note_first(std::nullopt, [&](Pulse pulse) { return pulse == settings_.raw_zero; });
    }
}

/// Most links never mark a frame. For them this keeps no history.
void LinkSupervisor::count_frame_lost(bool lost) {
    if (!lost && lost_count_ == 0) {
        return;
    }
    lost_count_ -= lost_marks_[next_mark_] ? 1U : 0U;
    lost_marks_[next_mark_] = lost;
    lost_count_ += lost ? 1U : 0U;
    next_mark_ = (next_mark_ + 1) % kRatioFrames;
}

/// The ratio must fall well below the limit before the link counts again, so that it does not
/// toggle.
bool LinkSupervisor::too_many_lost() const {
    constexpr double kSlack = 0.1;
    if (lost_count_ == 0) {
        return false;
    }
    const double limit = settings_.frame_lost_ratio;
    const bool already = radio_lost_ && sign_ == RadioLossSign::frame_lost_ratio;
    const double most = already ? std::max(limit - kSlack, limit / 2) : limit;
    return static_cast<double>(lost_count_) > most * kRatioFrames;
}

LinkSupervisor::Verdict LinkSupervisor::judge(const ChannelFrame& frame, Instant now) {
    if (frame.failsafe) {
        return {Kind::radio_lost, RadioLossSign::failsafe_flag};
    }
    if (rule_says_loss(frame)) {
        return {Kind::radio_lost, RadioLossSign::value_rule};
    }
    if (too_many_lost()) {
        return {Kind::radio_lost, RadioLossSign::frame_lost_ratio};
    }
    if (frame.frame_lost) {
        return {Kind::frame_lost, RadioLossSign::frame_lost_run};
    }
    if (!plausible(frame, now)) {
        note_implausible(frame, now);
        return {Kind::implausible, RadioLossSign::none};
    }
    return {channels_missing(frame, now) ? Kind::channels_missing : Kind::good,
            RadioLossSign::none};
}

bool LinkSupervisor::has_needed(const ChannelFrame& frame) const {
    return (frame.absent() & ~good_.absent() & ~settings_.optional_channels) == 0;
}

/// A frame without any channel is good only if all channels of the latest good one are optional.
bool LinkSupervisor::channels_missing(const ChannelFrame& frame, Instant now) {
    if (!frame.has_any() && !(ever_good_ && has_needed(frame))) {
        fewer_ = {};
        return true;
    }
    if (!ever_good_ || has_needed(frame)) {
        return false;
    }
    const std::uint32_t changed = frame.absent() ^ fewer_.absent();
    if (latest_kind_ != Kind::channels_missing || (changed & ~settings_.optional_channels) != 0) {
        fewer_ = frame;
        fewer_since_ = now;
    }
    return now < later(fewer_since_, settings_.fewer_channels_after);
}

Instant LinkSupervisor::not_after_frozen(Instant expiry) const {
    return settings_.frozen > Duration::zero()
               ? std::min(expiry, later(unchanged_since_, settings_.frozen))
               : expiry;
}

/// Compares channels only: a change of flags does not show that the values are alive. An
/// implausible frame does not show it either, because noise can damage a frame so that its sum is
/// still right. Noise does not do that to each frame for the timeout: after that the values are
/// new.
void LinkSupervisor::watch_for_change(const ChannelFrame& frame, Kind kind, Instant now) {
    const bool implausible_until_now =
        latest_kind_ == Kind::implausible && latest_frame_ - kind_since_ >= settings_.timeout;
    const bool changed = !ever_frame_ || implausible_until_now || !frame.same_channels(unchanged_);
    if (changed && kind != Kind::implausible) {
        unchanged_ = frame;
        unchanged_since_ = now;
    }
    expires_ = not_after_frozen(expires_);
}

void LinkSupervisor::take(ChannelFrame& frame, Instant now) {
    frame.frame_lost = frame.frame_lost && settings_.frame_lost_flag;
    frame.failsafe = frame.failsafe && settings_.failsafe_flag;
    count_frame_lost(frame.frame_lost);
    const Verdict verdict = judge(frame, now);
    if (verdict.kind == Kind::good) {
        accept(frame, now);
    } else {
        refuse(verdict, now);
    }
    if (settings_.frozen > Duration::zero()) {
        watch_for_change(frame, verdict.kind, now);
    }
    frame.failsafe = verdict.kind == Kind::radio_lost;
    kind_since_ = verdict.kind == latest_kind_ && ever_frame_ ? kind_since_ : now;
    latest_kind_ = verdict.kind;
    latest_frame_ = now;
    ever_frame_ = true;
}

void LinkSupervisor::accept(const ChannelFrame& frame, Instant now) {
    const bool was_lost = !alive(now);
    if (was_lost) {
        ++runs_;
        lost_before_run_ = ever_good_ ? lost_at() : now;
    }
    if (was_lost || (may_outlive_ && now - good_.received > settings_.timeout)) {
        run_start_ = has_needed(frame) || !ever_good_ ? now : fewer_since_;
        run_frames_ = 0;
    }
    ++run_frames_;
    may_outlive_ = false;
    radio_lost_ = false;
    channels_missing_ = false;
    ever_good_ = true;
    good_ = frame;
    expires_ = frame.received + settings_.timeout;
}

void LinkSupervisor::refuse(Verdict verdict, Instant now) {
    good_.frame_lost = true;
    if (verdict.kind == Kind::radio_lost) {
        if (!radio_lost_) {
            radio_lost_since_ = now;
            sign_ = verdict.sign;
        }
        radio_lost_ = true;
        guarded_ = false;
    } else if (verdict.kind == Kind::channels_missing) {
        if (!channels_missing_) {
            channels_missing_since_ = now;
        }
        channels_missing_ = true;
    } else if (verdict.kind == Kind::frame_lost && settings_.frame_lost_run && now < expires_) {
        // Frames still arrive. A link that is lost already stays lost.
        expires_ = std::min(now + settings_.timeout, good_.received + *settings_.frame_lost_run);
        may_outlive_ = true;
    }
}

LinkState LinkSupervisor::state_without_frames(Instant now) const {
    if (!ever_bytes_) {
        return {};
    }
    if (now - latest_bytes_ < settings_.timeout) {
        const LinkCause cause = decoder_ != nullptr ? decoder_->why_garbled() : LinkCause::garbled;
        // The first frame may still be under way, or wait for the one that proves it.
        const bool begins = !ever_frame_ && now - bytes_since_ < settings_.timeout;
        if (begins && cause == LinkCause::garbled) {
            return {};
        }
        return {cause, RadioLossSign::none,
                ever_frame_ ? std::max(bytes_since_, latest_frame_) : bytes_since_};
    }
    return {LinkCause::wire_silent, RadioLossSign::none, latest_bytes_};
}

LinkState LinkSupervisor::state(Instant now) const {
    if (alive(now)) {
        return {LinkCause::good, RadioLossSign::none, run_start_};
    }
    if (!ever_frame_ || now - latest_frame_ >= settings_.timeout) {
        return state_without_frames(now);
    }
    if (latest_kind_ == Kind::implausible) {
        return {LinkCause::implausible, RadioLossSign::none, kind_since_};
    }
    if (latest_kind_ == Kind::channels_missing) {
        return {LinkCause::channels_missing, RadioLossSign::none, kind_since_};
    }
    if (radio_lost_) {
        return {LinkCause::radio_lost, sign_, radio_lost_since_};
    }
    const bool frozen =
        settings_.frozen > Duration::zero() && now >= later(unchanged_since_, settings_.frozen);
    if (latest_kind_ == Kind::frame_lost && !frozen) {
        return {LinkCause::radio_lost, RadioLossSign::frame_lost_run, kind_since_};
    }
    return frozen ? LinkState{LinkCause::stale, RadioLossSign::none, unchanged_since_}
                  : LinkState{LinkCause::late, RadioLossSign::none, expires_};
}

void LinkSupervisor::bytes_came(Instant now) {
    if (!ever_bytes_ || now - latest_bytes_ >= settings_.timeout) {
        bytes_since_ = now;
    }
    ever_bytes_ = true;
    latest_bytes_ = now;
}

/// A link with its own time stamps, such as a CAN socket, may have delivered frames with times
/// after `since`. They do not count either.
void LinkSupervisor::was_away(Instant since, Instant now) {
    if (now - since < settings_.timeout) {
        return;
    }
    ++absences_;
    expires_ = std::min(expires_, since + settings_.timeout);
    if (run_start_ > since) {
        expires_ = std::min(expires_, lost_before_run_);
    }
    latest_frame_ = std::min(latest_frame_, since);
    latest_bytes_ = std::min(latest_bytes_, since);
}

}  // namespace tribus
