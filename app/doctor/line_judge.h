#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "app/doctor/line_heard.h"
#include "app/doctor/sbus_scale_guess.h"
#include "core/line_settings.h"
#include "core/time.h"

namespace tribus::doctor {

enum class LineSound : std::uint8_t {
    silence,       ///< no byte at all
    frames,        ///< a protocol, as it should be
    wrong_parity,  ///< its frames, but for parity bits that the protocol does not have, or lacks
    inverted,      ///< its frames turned over
    breaks,        ///< the line is low most of the time, and more cannot be said
    ibus2,         ///< FlySky's newer protocol, which nobody asked this program to speak
    unknown,       ///< bytes, of whatever
};
std::string_view sound_name(LineSound sound);

/// What a line carries.
struct LineStory {
    LineSound sound = LineSound::silence;
    /// As configurations call it: "ibus", "sbus"; "ibus-sensor" for the sensor bus. Empty where
    /// none was recognised.
    std::string_view protocol;
    LineSettings line;    ///< that it was heard with
    Duration listened{};  ///< with these settings; of a silence, with all
    std::uint64_t bytes = 0;
    std::uint64_t damaged = 0;  ///< of them, with a parity or framing error
    std::uint64_t frames = 0;
    std::uint64_t lost_bytes = 0;    ///< of no frame
    std::optional<Duration> period;  ///< of frames; where there are none, of what came regularly

    std::size_t channels = 0;  ///< with the two switches of SBUS
    std::uint64_t frame_lost = 0;
    std::uint64_t failsafe = 0;
    bool sbus2 = false;  ///< slots of telemetry follow the frames
    ScaleGuess scale;
    /// Of the channels that are present, in the default scale.
    std::optional<double> least_us;
    std::optional<double> most_us;
    /// Of the sensor bus; also where it shares the wire with i.Bus.
    std::uint64_t requests = 0;
    std::uint64_t replies = 0;
};

/// Judges what was heard of one line with one or several settings. Pure.
LineStory judge_line(std::span<const Heard> heard);

}  // namespace tribus::doctor
