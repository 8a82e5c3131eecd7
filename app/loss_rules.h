#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>

#include "core/channel_frame.h"
#include "core/time.h"
#include "pipelines/settings.h"

/// Values that tell a lost link from a flown one. Pure.
namespace tribus {

/// A frame as the decoder gave it, before any detector.
struct StudiedFrame {
    Instant at;
    ChannelFrame frame;
};
using StudiedFrames = std::span<const StudiedFrame>;

/// The values of a channel over some frames; nothing where it was always absent.
std::optional<PulseRange> pulses_of(StudiedFrames frames, std::size_t channel);

/// The rule that is true of all `lost` frames and has the most room to all that were `flown`: a
/// value beyond what a channel ever had, best of one that was moved, else one between the positions
/// of a switch. Nothing if none has enough.
std::optional<ValueRule> rule_that_tells(StudiedFrames flown, StudiedFrames lost);

/// Every channel that SBUS and i.Bus have numbers for, and that is present, at `zero`.
bool all_at(const ChannelFrame& frame, Pulse zero);

/// As in the configuration: "channel = 3, below = 950".
std::string rule_text(const ValueRule& rule);

}  // namespace tribus
