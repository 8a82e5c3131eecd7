#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>

#include "core/channel_frame.h"
#include "core/time.h"
#include "pipelines/rules/settings.h"

/// Rules that tell values of a lost link from values of a flown one. Pure.
namespace tribus {

/// A frame from the decoder, before loss detection.
struct StudiedFrame {
    Instant at;
    ChannelFrame frame;
};
using StudiedFrames = std::span<const StudiedFrame>;

/// The range of a channel in these frames; nothing if it was always absent.
std::optional<PulseRange> pulses_of(StudiedFrames frames, std::size_t channel);

/// The rule that matches all `lost` frames with the largest margin to all `flown` ones. Prefers a
/// value outside the range of a channel, best of one that was moved, to a value between the
/// positions of a switch. Nothing if no margin is large enough.
std::optional<ValueRule> rule_for_loss(StudiedFrames flown, StudiedFrames lost);

/// True if all present channels among the first 16 are at `zero`; channel 1 must be present.
bool all_at(const ChannelFrame& frame, Pulse zero);

/// Text as in the configuration: "channel = 3, below = 950".
std::string rule_text(const ValueRule& rule);

}  // namespace tribus
