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

/// Marks a frame of an input as loss although the receiver keeps sending: `failsafe_when`.
/// True when the channel is present and beyond any limit that is given.
struct LossRule {
    std::size_t channel = 0;
    std::optional<Pulse> below{};
    std::optional<Pulse> above{};
};

struct FromChannel {
    std::size_t channel = 0;
};
struct MixTerm {
    std::size_t channel = 0;
    double weight = 0;
};
/// Weighted sum of the deviations from 1500 us; absent if any of its channels is.
struct Mix {
    std::vector<MixTerm> terms;
};
struct Fixed {
    Pulse pulse;
};
/// 2000 us while the channel is beyond the limit, else 1000 us.
struct Switch {
    std::size_t channel = 0;
    std::optional<Pulse> above{};
    std::optional<Pulse> below{};
};
using ChannelSource = std::variant<FromChannel, Mix, Fixed, Switch>;

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
};

enum class FailsafeAction : std::uint8_t { preset, hold, silence };

struct FailsafeSettings {
    /// After the input is lost: last values, marked frame-lost, for so long.
    Duration hold = std::chrono::milliseconds(300);
    FailsafeAction action = FailsafeAction::preset;
    std::array<Pulse, kChannelCount> presets{};
    /// An unbroken run of good frames this long before control returns.
    Duration recover = std::chrono::milliseconds(500);
};

}  // namespace tribus
