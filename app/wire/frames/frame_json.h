#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include <tl/expected.hpp>

#include "app/wire/frames/frame_finder.h"
#include "core/channel_frame.h"
#include "core/pulse.h"
#include "core/time.h"

/// Decoded frames as JSON lines, which `decode` prints and `encode` reads.
namespace tribus {

/// Exact: whole microseconds without a decimal point, eighths with up to three decimals.
void append_pulse(std::string& text, Pulse pulse);

/// Rounded to the nearest.
std::int64_t whole_microseconds(Duration duration);

/// Appends one object and a line end: t_us (if known), protocol, the 18 channels with null for an
/// absent one, frame_lost, failsafe, and the protocol's own details.
void append_frame_json(std::string& text, const FoundFrame& found);

/// Appends the summary object and a line end. `input` names the kind of the recording.
/// On CAN, `log_start_us` is the time in the log that is 0 in the output.
void append_summary_json(std::string& text, const Tally& tally, std::string_view input);

/// A frame as read from one line.
struct WrittenFrame {
    std::optional<Duration> start;
    ChannelFrame channels;
};

/// A mistake in a line; `column` counts from 1.
struct JsonMistake {
    std::size_t column = 1;
    std::string text;
};

/// Parses one line. Returns nothing for a blank line, the summary, or a DroneCAN transfer without
/// channels. Other lines need `channels`: up to 18 numbers in microseconds or nulls; missing ones
/// are absent. frame_lost and failsafe default to false; unknown keys are skipped. Pulses are
/// rounded to eighths of a microsecond.
tl::expected<std::optional<WrittenFrame>, JsonMistake> parse_frame_json(std::string_view line);

}  // namespace tribus
