#include "app/learn/loss_study.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "app/learn/loss_rules.h"
#include "config/schema/notation.h"
#include "pipelines/rules/link_supervisor.h"

namespace tribus {
namespace {

/// A few stray frames around the switching prove nothing.
constexpr double kNearlyAll = 0.95;
constexpr double kNearlyNone = 0.02;
/// Below the stick range of every transmitter, even with extended end points.
constexpr int kSuggestedPulse = 900;
constexpr Duration kLeastFrozen = std::chrono::seconds(2);

StudiedFrames between(StudiedFrames frames, Instant from, Instant until) {
    const auto first = std::ranges::lower_bound(frames, from, {}, &StudiedFrame::at);
    const auto last = std::ranges::lower_bound(frames, until, {}, &StudiedFrame::at);
    return {first, last};
}

template <class Predicate>
double share(StudiedFrames frames, Predicate predicate) {
    return frames.empty() ? 0
                          : static_cast<double>(std::ranges::count_if(frames, predicate)) /
                                static_cast<double>(frames.size());
}

bool has_failsafe_flag(const StudiedFrame& studied) {
    return studied.frame.failsafe;
}
bool has_frame_lost_flag(const StudiedFrame& studied) {
    return studied.frame.frame_lost && !studied.frame.failsafe;
}

Duration longest_still(StudiedFrames frames) {
    Duration longest{};
    std::size_t since = 0;
    for (std::size_t i = 1; i < frames.size(); ++i) {
        if (!frames[i].frame.same_channels(frames[since].frame)) {
            since = i;
        }
        longest = std::max(longest, frames[i].at - frames[since].at);
    }
    return longest;
}

Duration longest_gap(StudiedFrames frames) {
    Duration longest{};
    for (std::size_t i = 1; i < frames.size(); ++i) {
        longest = std::max(longest, frames[i].at - frames[i - 1].at);
    }
    return longest;
}

std::string seconds_text(Duration duration) {
    return fmt::format("{:.1f} s", seconds_of(duration));
}

/// Rounded up to whole seconds.
Duration whole_seconds(Duration duration) {
    return std::chrono::ceil<std::chrono::seconds>(duration);
}

/// The frames of a study, by what the person did.
struct Phases {
    StudiedFrames flown;
    StudiedFrames off;
    StudiedFrames
        settled;  ///< the second half of `off`: receivers need up to two seconds to notice
    StudiedFrames back;
};

Phases phases_of(StudiedFrames frames, const LossStudyTimes& times) {
    const Instant settled = times.off + (times.back - times.off) / 2;
    return {.flown = between(frames, Instant::min(), times.off),
            .off = between(frames, times.off, times.back),
            .settled = between(frames, settled, times.back),
            .back = between(frames, times.back, kNever)};
}

class Study {
  public:
    Study(const InputConfig& input, StudiedFrames frames, const LossStudyTimes& times)
        : times_(times), phases_(phases_of(frames, times)) {
        result_.supervision = input.supervision;
    }

    LossStudyResult run() {
        if (phases_.flown.empty()) {
            result_.findings.emplace_back("no frame came while the transmitter was on");
            result_.advice.emplace_back(
                "check the connection, the protocol and the binding first; `tribus run` says what "
                "it receives");
            return std::move(result_);
        }
        check_flags();
        find_detector();
        find_zero_guard();
        play();
        give_advice();
        return std::move(result_);
    }

  private:
    void add_finding(std::string finding) { result_.findings.push_back(std::move(finding)); }
    void line(std::string text) { result_.lines.push_back(std::move(text)); }
    void check_flags();
    void find_detector();
    void find_by_values();
    void find_by_frozen_values();
    void find_zero_guard();
    void play();
    void give_advice();

    LossStudyTimes times_;
    Phases phases_;
    LossStudyResult result_;
};

/// A flag that is set while the transmitter is on is useless.
void Study::check_flags() {
    SupervisionSettings& supervision = result_.supervision;
    if (share(phases_.flown, has_failsafe_flag) > kNearlyNone && supervision.failsafe_flag) {
        add_finding("the receiver says failsafe while the transmitter is on");
        supervision.failsafe_flag = false;
        line("failsafe_flag = false");
    }
    if (share(phases_.flown, has_frame_lost_flag) > kNearlyAll && supervision.frame_lost_flag) {
        add_finding("the receiver marks every frame as lost, although the transmitter is on");
        supervision.frame_lost_flag = false;
        line("frame_lost_flag = false");
    }
}

void Study::find_detector() {
    SupervisionSettings& supervision = result_.supervision;
    const Duration gap = longest_gap(phases_.flown);
    if (gap >= supervision.timeout) {
        supervision.timeout = 2 * gap;
        line(fmt::format("timeout = \"{}ms\"",
                         std::chrono::ceil<std::chrono::milliseconds>(2 * gap).count()));
        add_finding(
            fmt::format("frames came up to {} apart while the transmitter was on",
                        format_duration(std::chrono::ceil<std::chrono::milliseconds>(gap))));
    }
    if (phases_.settled.empty()) {
        add_finding(phases_.off.empty()
                        ? std::string("the receiver stops sending at once")
                        : fmt::format("the receiver stops sending {} after the switch",
                                      seconds_text(phases_.off.back().at - times_.off)));
    } else if (share(phases_.settled, has_failsafe_flag) > kNearlyAll &&
               supervision.failsafe_flag) {
        add_finding("the receiver goes on sending and says failsafe");
    } else if (share(phases_.settled, has_frame_lost_flag) > kNearlyAll &&
               supervision.frame_lost_flag) {
        add_finding(
            "the receiver goes on sending and marks every frame as lost, but never says failsafe");
    } else if (!supervision.failsafe_when.empty() &&
               share(phases_.settled, [&](const StudiedFrame& studied) {
                   return std::ranges::any_of(supervision.failsafe_when, [&](const ValueRule& r) {
                       return r.all_zero ? all_at(studied.frame, *supervision.raw_zero)
                                         : r.matches(studied.frame);
                   });
               }) > kNearlyAll) {
        add_finding(
            "the receiver goes on sending, and failsafe_when recognises its values already");
    } else {
        find_by_values();
    }
}

void Study::find_by_values() {
    SupervisionSettings& supervision = result_.supervision;
    const auto zero = supervision.raw_zero;
    std::optional<ValueRule> rule;
    if (zero && share(phases_.settled, [&](const StudiedFrame& studied) {
                    return all_at(studied.frame, *zero);
                }) > kNearlyAll) {
        rule = ValueRule{.all_zero = true};
        add_finding("the receiver goes on sending, without a flag, all channels at zero");
    } else if ((rule = rule_for_loss(phases_.flown, phases_.settled))) {
        const PulseRange lost = *pulses_of(phases_.settled, rule->channel);
        const PulseRange flown = *pulses_of(phases_.flown, rule->channel);
        add_finding(
            fmt::format("the receiver goes on sending, without a flag; channel {} is then {} us, "
                        "and {} to {} us while the transmitter is on",
                        rule->channel + 1, lost.low.whole_microseconds(),
                        flown.low.whole_microseconds(), flown.high.whole_microseconds()));
    }
    if (rule) {
        supervision.failsafe_when.push_back(*rule);
        line(fmt::format("failsafe_when = [{{ {} }}]", rule_text(*rule)));
        return;
    }
    find_by_frozen_values();
}

/// Last resort: held values do not change, those of a transmitter nearly always do.
void Study::find_by_frozen_values() {
    const bool held =
        longest_still(phases_.settled) == phases_.settled.back().at - phases_.settled.front().at;
    const Duration still = longest_still(phases_.flown);
    add_finding(
        held ? "the receiver goes on sending, without a flag, values that could be flown and do "
               "not change"
             : "the receiver goes on sending, without a flag, values that could be flown");
    const Duration frozen = std::max(kLeastFrozen, whole_seconds(3 * still));
    if (held && frozen <= (times_.back - times_.off) / 2) {
        add_finding(
            fmt::format("while the transmitter was on its values stood still for {} at most",
                        seconds_text(still)));
        result_.supervision.frozen = frozen;
        line(fmt::format("frozen = \"{}\"", format_duration(frozen)));
        result_.advice.push_back(fmt::format(
            "`frozen` is a last resort: for {} the old values are taken for good ones. Better give "
            "the receiver a failsafe value that is never flown, and learn again.",
            format_duration(frozen)));
    }
}

/// For receivers that clear their flag before their channels are back.
void Study::find_zero_guard() {
    const auto zero = result_.supervision.raw_zero;
    if (!zero) {
        return;
    }
    std::optional<Instant> first;
    std::optional<Instant> last;
    for (const StudiedFrame& studied : phases_.back) {
        if (studied.frame.failsafe || all_at(studied.frame, *zero)) {
            continue;
        }
        for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
            const bool is_zero = studied.frame.channel(channel) == zero;
            const auto flown = is_zero ? pulses_of(phases_.flown, channel) : std::nullopt;
            if (flown && flown->low > *zero) {
                first = first.value_or(studied.at);
                last = studied.at;
            }
        }
    }
    if (!first) {
        return;
    }
    const Duration lasted = *last - *first;
    add_finding(
        fmt::format("when the transmitter is back, channels stay at zero for {} after the flag is "
                    "gone",
                    seconds_text(lasted)));
    if (2 * lasted > result_.supervision.zero_guard) {
        result_.supervision.zero_guard = whole_seconds(2 * lasted);
        line(fmt::format("zero_guard = \"{}\"", format_duration(result_.supervision.zero_guard)));
    }
}

/// Plays the frames through the detectors: they must find the loss and nothing else.
void Study::play() {
    LinkSupervisor link(result_.supervision);
    bool false_alarm = false;
    Instant previous = phases_.flown.front().at;
    const auto look = [&](Instant now) {
        if (link.ever_good() && !link.alive(now)) {
            const Instant lost = std::max(previous, link.lost_at());
            false_alarm = false_alarm || lost < times_.off;
            result_.time_to_loss = result_.time_to_loss.value_or(lost - times_.off);
        }
        previous = now;
    };
    const auto take = [&](const StudiedFrame& studied) {
        ChannelFrame frame = studied.frame;
        frame.received = studied.at;
        link.bytes_came(studied.at);
        link.take(frame, studied.at);
    };
    for (const StudiedFrames& phase : {phases_.flown, phases_.off}) {
        for (const StudiedFrame& studied : phase) {
            look(studied.at);
            take(studied);
            look(studied.at);
        }
    }
    look(times_.back);
    result_.recognised = result_.time_to_loss && !link.alive(times_.back) && !false_alarm;
    for (const StudiedFrame& studied : phases_.back) {
        take(studied);
        if (!result_.time_to_return && link.alive(studied.at)) {
            result_.time_to_return = studied.at - times_.back;
        }
    }
    if (false_alarm) {
        add_finding("with these detectors the link would sometimes be lost while nothing is wrong");
    }
}

void Study::give_advice() {
    if (result_.recognised) {
        return;
    }
    result_.lines.clear();
    result_.advice.insert(
        result_.advice.begin(),
        fmt::format(
            "The loss of this receiver looks the same as a pilot who holds the sticks still. Set a "
            "failsafe on the transmitter: a throttle of about {} us, below its "
            "stick's range. Where the transmitter allows no such value, open the end point "
            "of the throttle (-120 %), store the failsafe with the stick at its low end, "
            "and set the end point back. If the receiver can stop sending (\"no pulses\", "
            "\"cut\"), choose that. Then learn again.",
            kSuggestedPulse));
}

}  // namespace

LossStudyResult study_loss(const InputConfig& input, StudiedFrames frames,
                           const LossStudyTimes& times) {
    return Study(input, frames, times).run();
}

}  // namespace tribus
