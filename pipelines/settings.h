#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/channel_frame.h"
#include "core/pulse.h"
#include "core/schedule.h"
#include "core/time.h"

/// What the parts of a pipeline are made from: plain values, complete and already checked.
/// Channels count from 0.
namespace tribus {

/// Both ends included.
struct PulseRange {
    Pulse low;
    Pulse high;

    bool contains(Pulse pulse) const { return low <= pulse && pulse <= high; }

    bool operator==(const PulseRange&) const = default;
};

/// A condition on the values of a frame, for `failsafe_when` and `release_when`. True when the
/// channel is present and beyond a limit, or within the range, that is given; with `all_zero`, of
/// failsafe_when only, when every channel reads the wire's own zero.
struct ValueRule {
    bool all_zero = false;
    std::size_t channel = 0;
    std::optional<Pulse> below{};
    std::optional<Pulse> above{};
    std::optional<PulseRange> between{};

    bool matches(Pulse pulse) const {
        return (below && pulse < *below) || (above && pulse > *above) ||
               (between && between->contains(pulse));
    }
    /// By its channel.
    bool matches(const ChannelFrame& frame) const {
        return frame.has(channel) && matches(frame.pulses()[channel]);
    }

    bool operator==(const ValueRule&) const = default;
};

/// How an input is judged. Every detector but the timeout has a value that turns it off.
struct SupervisionSettings {
    /// No good frame for so long: this input is lost.
    Duration timeout = std::chrono::milliseconds(100);
    /// The sender's own flags count.
    bool failsafe_flag = true;
    bool frame_lost_flag = true;
    std::vector<ValueRule> failsafe_when{};
    /// Nothing but frames marked frame-lost for so long: lost. Where absent, the timeout.
    std::optional<Duration> frame_lost_run{};
    /// A larger share of frames marked frame-lost among the latest hundred: lost. 1: never.
    double frame_lost_ratio = 0.9;
    /// No change of any bit of a channel for so long: lost. Zero: never.
    Duration frozen{};
    /// A sender that leaves out channels that it had is lost until they are back, or until it has
    /// sent the same fewer ones for so long without a break: then it means it.
    Duration fewer_channels_after = std::chrono::milliseconds(100);
    /// A frame with a channel outside of it does not count.
    std::optional<PulseRange> plausible{};
    /// What a channel reads whose value on the wire is zero, where that means "no value".
    std::optional<Pulse> raw_zero{};
    /// For so long after the start and after a loss, a frame with such a channel does not count.
    Duration zero_guard = std::chrono::seconds(1);

    bool operator==(const SupervisionSettings&) const = default;
};

struct FromChannel {
    std::size_t channel = 0;

    bool operator==(const FromChannel&) const = default;
};
struct MixTerm {
    std::size_t channel = 0;
    double weight = 0;

    bool operator==(const MixTerm&) const = default;
};
/// Weighted sum of the deviations from 1500 us; absent if any of its channels is.
struct Mix {
    std::vector<MixTerm> terms;

    bool operator==(const Mix&) const = default;
};
struct Fixed {
    Pulse pulse;

    bool operator==(const Fixed&) const = default;
};
/// 2000 us while the channel is beyond the limit, else 1000 us.
struct Switch {
    std::size_t channel = 0;
    std::optional<Pulse> above{};
    std::optional<Pulse> below{};

    bool operator==(const Switch&) const = default;
};
/// 2000 us while that input line is active, else 1000 us; absent while it cannot be read.
struct FromLine {
    std::size_t line = 0;

    bool operator==(const FromLine&) const = default;
};
using ChannelSource = std::variant<FromChannel, Mix, Fixed, Switch, FromLine>;

/// How one output channel is made. The steps run in the order in which they stand here.
struct ChannelRule {
    std::size_t output = 0;
    ChannelSource source;
    Pulse deadband{};  ///< this far around 1500 us reads as 1500; full travel is kept
    double expo = 0;   ///< 0 straight, 1 cubic; 1000, 1500 and 2000 us stay where they are
    bool reverse = false;
    Pulse trim{};                                ///< added
    std::optional<double> slew_us_per_second{};  ///< fastest change
    std::optional<Pulse> min{};
    std::optional<Pulse> max{};

    bool operator==(const ChannelRule&) const = default;
};

enum class SelectionMode : std::uint8_t {
    priority,  ///< the first healthy one; it comes back once it has recovered
    sticky,    ///< the one in control, until it fails
    freshest,  ///< for each frame the one whose values are youngest
    median,    ///< the middle of all, channel by channel: a single liar is outvoted
};

/// A person picks the input with a channel of one of them: its travel from 1000 to 2000 us is
/// divided evenly among the inputs; of a median, its lowest part picks none.
struct HandoverSettings {
    std::size_t input = 0;  ///< place in the list of inputs
    std::size_t channel = 0;

    bool operator==(const HandoverSettings&) const = default;
};

/// No pipeline has more inputs.
inline constexpr std::size_t kMostPipelineInputs = 16;

/// How an output chooses among its inputs.
struct SelectionSettings {
    /// Indices, the preferred first.
    std::vector<std::size_t> inputs;
    SelectionMode mode = SelectionMode::priority;
    /// An input that differs by more from the median of three or more dissents.
    Pulse tolerance = Pulse::from_microseconds(50);
    std::optional<HandoverSettings> handover{};
    /// Fastest change of a channel while control passes to another input; absent: at once.
    std::optional<double> changeover_us_per_second{};

    bool operator==(const SelectionSettings&) const = default;
};

enum class FailsafeAction : std::uint8_t { preset, hold, silence };

struct FailsafeSettings {
    /// After the input is lost: last values, marked frame-lost, for so long.
    Duration hold = std::chrono::milliseconds(300);
    FailsafeAction action = FailsafeAction::preset;
    std::array<Pulse, kChannelCount> presets{};
    /// Fastest change of a channel into the presets, and from them back; absent: at once.
    std::optional<double> slew_us_per_second{};
    /// An unbroken run of good frames this long before control returns.
    Duration recover = std::chrono::milliseconds(500);
    /// The same before control is given for the first time.
    Duration power_on{};
    /// After failsafe, and at the start, control waits until this is true of the output's channels.
    std::optional<ValueRule> release_when{};

    bool operator==(const FailsafeSettings&) const = default;
};

/// What a GPIO line is for. By outputs, those of `LineTask`.
enum class LineRole : std::uint8_t {
    link,            ///< output: on under control, blinking while values are held, off in failsafe
    failsafe,        ///< output: active while one of the outputs is in failsafe
    fresh,           ///< output: a square wave that only fresh data on time makes
    force_failsafe,  ///< input: active, or gone: the outputs are in failsafe
    select,          ///< input: while active, `input` is picked
    inverter,        ///< output: active from start to end
    button,          ///< input: the source of channels
    channel_switch,  ///< output: active while what the output says matches `rule`
};

inline bool is_input_role(LineRole role) {
    return role == LineRole::force_failsafe || role == LineRole::select || role == LineRole::button;
}

struct LineTask {
    LineRole role = LineRole::link;
    /// Indices of those that it shows or forces.
    std::vector<std::size_t> outputs{};
    std::size_t input = 0;
    ValueRule rule{};
    /// Of the wave.
    Duration period = std::chrono::milliseconds(40);
    /// A level counts once it has stood still for so long.
    Duration debounce = std::chrono::milliseconds(20);

    bool operator==(const LineTask&) const = default;
};

}  // namespace tribus
