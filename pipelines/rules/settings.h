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

/// Settings of the parts of a pipeline: plain values, complete and already checked. Channels count
/// from 0.
namespace tribus {

/// Includes both ends.
struct PulseRange {
    Pulse low;
    Pulse high;

    bool contains(Pulse pulse) const { return low <= pulse && pulse <= high; }

    bool operator==(const PulseRange&) const = default;
};

/// A condition on the channel values of a frame, for `failsafe_when` and `release_when`. True if
/// the channel is present and exceeds one of the given limits or lies in the given range. With
/// `all_zero` (`failsafe_when` only): true if every channel has the raw value zero.
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
    /// False if the frame lacks the channel.
    bool matches(const ChannelFrame& frame) const {
        return frame.has(channel) && matches(frame.pulses()[channel]);
    }

    bool operator==(const ValueRule&) const = default;
};

/// How the link of an input is judged. Each check except the timeout has a value that turns it off.
struct SupervisionSettings {
    /// The input is lost after this time without a good frame.
    Duration timeout = std::chrono::milliseconds(100);
    /// Whether the sender's flags count.
    bool failsafe_flag = true;
    bool frame_lost_flag = true;
    std::vector<ValueRule> failsafe_when{};
    /// The input is lost after this time in which every frame was marked frame-lost. Absent:
    /// `timeout`.
    std::optional<Duration> frame_lost_run{};
    /// The input is lost if more than this share of its latest 100 frames is marked frame-lost. 1:
    /// never.
    double frame_lost_ratio = 0.9;
    /// The input is lost if no bit of any channel has changed for this time. Zero: never.
    Duration frozen{};
    /// A sender that omits channels which it sent before is lost until they are back, or until it
    /// has sent the same smaller set for this time without interruption.
    Duration fewer_channels_after = std::chrono::milliseconds(100);
    /// The channels whose absence is no loss, one bit each.
    std::uint32_t optional_channels = 0;
    /// A frame with a channel outside this range is not good.
    std::optional<PulseRange> plausible{};
    /// Pulse of a channel whose raw value is zero, where zero means "no value". Absent: it has no
    /// such meaning.
    std::optional<Pulse> raw_zero{};
    /// For this time after the start and after a loss, a frame with such a channel is not good.
    Duration zero_guard = std::chrono::seconds(1);

    bool operator==(const SupervisionSettings&) const = default;
};

struct FromChannel {
    std::size_t channel = 0;

    bool operator==(const FromChannel&) const = default;
};
/// Term of a mix.
struct MixTerm {
    std::size_t channel = 0;
    double weight = 0;

    bool operator==(const MixTerm&) const = default;
};
/// Weighted sum of the deviations from 1500 us. Absent if any of its channels is absent.
struct Mix {
    std::vector<MixTerm> terms;

    bool operator==(const Mix&) const = default;
};
/// A constant pulse.
struct Fixed {
    Pulse pulse;

    bool operator==(const Fixed&) const = default;
};
/// 2000 us while the channel is above `above` or below `below`, else 1000 us. Has at least one
/// limit.
struct Switch {
    std::size_t channel = 0;
    std::optional<Pulse> above{};
    std::optional<Pulse> below{};

    bool operator==(const Switch&) const = default;
};
/// 2000 us while the input line is active, else 1000 us. Absent while the line cannot be read.
struct FromLine {
    std::size_t line = 0;

    bool operator==(const FromLine&) const = default;
};
using ChannelSource = std::variant<FromChannel, Mix, Fixed, Switch, FromLine>;

/// How one output channel is made. The steps run in the order of the members.
struct ChannelRule {
    std::size_t output = 0;
    ChannelSource source;
    Pulse deadband{};  ///< pulses this close to 1500 us become 1500 us; full travel stays
    double expo = 0;   ///< 0: linear, 1: cubic; 1000, 1500 and 2000 us stay
    bool reverse = false;
    Pulse trim{};                                ///< added
    std::optional<double> slew_us_per_second{};  ///< limit of the rate of change
    std::optional<Pulse> min{};
    std::optional<Pulse> max{};

    bool operator==(const ChannelRule&) const = default;
};

/// How the input in control is selected.
enum class SelectionMode : std::uint8_t {
    priority,  ///< the first healthy input; a better one takes over once it has recovered
    sticky,    ///< the input in control, until it is lost
    freshest,  ///< for each frame, the input with the newest values
    median,    ///< the median of all inputs for each channel, so that one wrong input is outvoted
};

/// A channel of one input selects the input in control: its travel from 1000 to 2000 us is divided
/// evenly among the inputs. In median mode the lowest part selects the median.
struct HandoverSettings {
    std::size_t input = 0;  ///< index in the pipeline's list of inputs
    std::size_t channel = 0;

    bool operator==(const HandoverSettings&) const = default;
};

/// Upper limit of the number of inputs of a pipeline.
inline constexpr std::size_t kMostPipelineInputs = 16;

/// How an output selects its input.
struct SelectionSettings {
    /// Indices of the inputs, the preferred one first.
    std::vector<std::size_t> inputs;
    SelectionMode mode = SelectionMode::priority;
    /// An input dissents if it differs by more than this from the median of three or more inputs.
    Pulse tolerance = Pulse::from_microseconds(50);
    std::optional<HandoverSettings> handover{};
    /// Limit of the rate of change of a channel while control passes to another input. Absent: no
    /// limit.
    std::optional<double> changeover_us_per_second{};

    bool operator==(const SelectionSettings&) const = default;
};

enum class FailsafeAction : std::uint8_t { preset, hold, silence };

/// What an output sends after a loss.
struct FailsafeSettings {
    /// After a loss the output holds the last values, marked frame-lost, for this time.
    Duration hold = std::chrono::milliseconds(300);
    FailsafeAction action = FailsafeAction::preset;
    std::array<Pulse, kChannelCount> presets{};
    /// Limit of the rate of change of a channel into the presets and back. Absent: no limit.
    std::optional<double> slew_us_per_second{};
    /// Control returns after good frames without interruption for this time.
    Duration recover = std::chrono::milliseconds(500);
    /// The same before an input gets control for the first time.
    Duration power_on{};
    /// After failsafe and at the start, control waits until this holds for the output's channels.
    std::optional<ValueRule> release_when{};

    bool operator==(const FailsafeSettings&) const = default;
};

/// Role of a GPIO line. "The outputs" are those in `LineTask::outputs`.
enum class LineRole : std::uint8_t {
    link,            ///< output: on in control, blinks while values are held, off in failsafe
    failsafe,        ///< output: active while any of the outputs is in failsafe
    fresh,           ///< output: a square wave while fresh data is sent on time
    force_failsafe,  ///< input: while active or unreadable, the outputs are in failsafe
    select,          ///< input: while active, selects `input`
    inverter,        ///< output: active from start to end of the program
    button,          ///< input: source of channels
    channel_switch,  ///< output: active while the frame of the output matches `rule`
};

inline bool is_input_role(LineRole role) {
    return role == LineRole::force_failsafe || role == LineRole::select || role == LineRole::button;
}

/// The longest period of the wave of `fresh`: a gate for a longer one would open too late.
inline constexpr Duration kMostWavePeriod = std::chrono::seconds(2);

/// What one GPIO line does.
struct LineTask {
    LineRole role = LineRole::link;
    /// Indices of the outputs that the line shows or forces.
    std::vector<std::size_t> outputs{};
    std::size_t input = 0;
    ValueRule rule{};
    /// Period of the wave of `fresh`.
    Duration period = std::chrono::milliseconds(40);
    /// A new level counts after it was stable for this time.
    Duration debounce = std::chrono::milliseconds(20);

    bool operator==(const LineTask&) const = default;
};

}  // namespace tribus
