#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "pipelines/engine/output.h"
#include "pipelines/rules/link_supervisor.h"

namespace tribus {

/// For the log and reports: the cause and its sign, such as "radio lost (the receiver says
/// failsafe)". `implausible`: frames of the input, named if they are the cause. `fault`: what its
/// decoder says of frames that do not count, in place of the sign.
std::string cause_text(const LinkState& state, const ImplausibleFrames& implausible = {},
                       std::string_view fault = {});
/// A value of an implausible frame: "channel 5 is at 2158 us, plausible are 900 to 2100 us".
std::string implausible_text(const ImplausibleFrames& implausible);

/// A name as machines read it: "radio_lost".
std::string as_word(std::string_view name);
/// The other way round, for people: "radio lost".
std::string in_words(std::string_view word);
/// All words of the next function.
inline constexpr std::array<std::string_view, 5> kOutputStateWords{"control", "hold", "failsafe",
                                                                   "silent", "cannot_send"};
/// The output's `state` in a status: "control", "hold", "failsafe", "cannot_send", or "silent" for
/// an output that sends nothing in failsafe.
std::string_view output_state_word(OutputStage stage, bool sends);

/// Why an output cannot send, and what it waits for then.
struct ObstacleText {
    std::string_view fault;
    std::string_view awaited;
};
/// Both are empty for `SendObstacle::none`.
ObstacleText obstacle_text(SendObstacle obstacle);

/// The state of an output in words: "under control of backup", "in failsafe until release_when is
/// true". `inputs`: names of all inputs, by index.
std::string output_text(const OutputState& state, std::span<const std::string> inputs);

/// Text for the bits of `OutputState::by_preset`: the output channels that send their presets.
std::string by_preset_text(std::uint32_t channels);
/// Text for an input whose `DecoderReport::two_senders` is true.
inline constexpr std::string_view kTwoSendersText =
    "its frames come with two periods, as from two senders; without a counter they cannot be told "
    "apart, and their values mix";

}  // namespace tribus
