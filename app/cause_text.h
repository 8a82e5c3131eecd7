#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "pipelines/link_supervisor.h"
#include "pipelines/output.h"

namespace tribus {

/// For the log and reports: the cause and how it shows, as "radio lost (the receiver says
/// failsafe)".
std::string cause_text(const LinkState& state);

/// A name as keys are written, for machines: "radio_lost".
std::string as_word(std::string_view name);
/// "control", "hold", "failsafe", "cannot_send"; an output that says nothing in failsafe:
/// "silent".
std::string_view stage_word(OutputStage stage, bool sends);

/// The same of an output: "under control of backup", "in failsafe until it is released".
/// `inputs` are the names of all inputs, by index.
std::string output_text(const OutputState& state, std::span<const std::string> inputs);

/// "channels 3, 4 say their presets: the channels that the map makes them of are absent", for the
/// bits of `OutputState::by_preset`.
std::string by_preset_text(std::uint32_t channels);
/// What is said of an input whose `DecoderReport::two_senders` is true.
inline constexpr std::string_view kTwoSendersText =
    "its frames come in two rhythms, as from two senders; without a counter they cannot be told "
    "apart, and their values mix";

}  // namespace tribus
