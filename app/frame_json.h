#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include <tl/expected.hpp>

#include "app/can_frame_finder.h"
#include "app/frame_finder.h"
#include "core/channel_frame.h"
#include "core/pulse.h"
#include "core/time.h"

/// Decoded frames as JSON lines, both ways: the form that `decode` prints and `encode` reads.
namespace tribus {

/// Exact: whole microseconds without a point, eighths as up to three decimals.
void append_pulse(std::string& text, Pulse pulse);

/// To the nearest.
std::int64_t whole_microseconds(Duration duration);

/// Adds one object and a line end: t_us (where known), protocol, the 18 channels with null for an
/// absent one, frame_lost, failsafe, then the protocol's own details.
void append_frame_json(std::string& text, const FoundFrame& found);

/// Adds the closing object and a line end. `input` names the kind of the recording.
void append_summary_json(std::string& text, const Tally& tally, std::string_view input);
/// The same for CAN: `log_start_us` is what the log calls the time that is 0 here.
void append_can_summary_json(std::string& text, const CanTally& tally, std::string_view input);

/// What one line says about a frame.
struct WrittenFrame {
    std::optional<Duration> start;
    ChannelFrame channels;
};

struct JsonMistake {
    std::size_t column = 1;
    std::string text;
};

/// Reads one line. Nothing for a blank line, for the summary and for a transfer of DroneCAN that
/// has no channels. Else `channels` is needed: up to 18 microseconds or nulls, those that are
/// missing are absent; frame_lost and failsafe default to false; keys that are not known are passed
/// over. Pulses are rounded to eighths.
tl::expected<std::optional<WrittenFrame>, JsonMistake> parse_frame_json(std::string_view line);

}  // namespace tribus
