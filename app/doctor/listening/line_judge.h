#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "app/doctor/listening/line_heard.h"
#include "app/doctor/listening/sbus_scale_guess.h"
#include "core/line_settings.h"
#include "core/time.h"

namespace tribus::doctor {

enum class LineSound : std::uint8_t {
    silence,       ///< no byte
    frames,        ///< valid frames of a protocol
    wrong_parity,  ///< frames of a protocol with wrong parity: a parity bit too many, or none
    inverted,      ///< inverted frames of a protocol
    breaks,        ///< the line is low most of the time; nothing else is known
    ibus2,         ///< FlySky's newer protocol; tribus only listens to it
    sbus24,        ///< FrSky's SBUS with 24 channels
    unknown,       ///< bytes of unknown origin
};
std::string_view sound_name(LineSound sound);

/// What a line carries.
struct LineStory {
    LineSound sound = LineSound::silence;
    /// As in configurations: "ibus", "sbus"; "ibus-sensor" for the sensor bus. Empty if no protocol
    /// was recognised.
    std::string_view protocol;
    LineSettings line;    ///< settings with which it was received
    Duration listened{};  ///< with these settings; for silence, with all
    std::uint64_t bytes = 0;
    std::uint64_t damaged = 0;  ///< of these, with a parity or framing error
    std::uint64_t frames = 0;
    std::uint64_t lost_bytes = 0;    ///< bytes outside frames
    std::optional<Duration> period;  ///< of frames; without frames, of whatever came regularly

    std::size_t channels = 0;  ///< includes the two switches of SBUS
    std::uint64_t frame_lost = 0;
    std::uint64_t failsafe = 0;
    bool sbus2 = false;  ///< telemetry slots follow the frames
    ScaleGuess scale;
    /// Over all present channels, in the default scale.
    std::optional<double> least_us;
    std::optional<double> most_us;
    /// Counters of the sensor bus, also if it shares the wire with i.Bus.
    std::uint64_t requests = 0;
    std::uint64_t replies = 0;
};

/// Judges a line from what was received with one or several settings. Pure.
LineStory judge_line(std::span<const Heard> heard);

}  // namespace tribus::doctor
