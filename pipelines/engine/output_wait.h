#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "core/pulse.h"
#include "core/time.h"
#include "pipelines/rules/link_supervisor.h"
#include "pipelines/rules/settings.h"
#include "transports/codecs/codec.h"

namespace tribus {

/// What an output that is not in control waits for.
enum class Awaited : std::uint8_t {
    nothing,      ///< it is in control, or cannot send
    link,         ///< the link of the input is lost
    good_frame,   ///< the link counts, but its good frame is too old
    run_time,     ///< the input's run of good frames is too short
    run_frames,   ///< the input's run has too few good frames
    votes,        ///< the other inputs have outvoted the input
    next_frame,   ///< the input can be used; the output's next frame is not due yet
    release,      ///< `release_when` is not true
    line,         ///< a GPIO line forces failsafe
    other_node,   ///< another node sends with the CAN ids of the output
    after_force,  ///< the time of `recover` after one of the former two
    end,          ///< the program ends
};

/// The thing that an output waits for, and how far that is.
struct OutputWait {
    Awaited awaited = Awaited::nothing;
    /// Index of the input. Absent if `awaited` has nothing to do with one.
    std::optional<std::size_t> input{};
    /// State of that input's link, and what its decoder says of it.
    LinkState link{};
    FaultText fault{};
    /// Its loss within the last 10 s, and how long ago that was. `good`: there was none.
    LinkState loss{.cause = LinkCause::good};
    Duration loss_age{};
    /// Frames of that input that brought no news: how many of the latest were marked frame-lost,
    /// and those of the last second with implausible values.
    std::size_t marked = 0;
    std::size_t latest = 0;
    std::optional<ImplausibleFrames> implausible{};
    /// `run_time`, `after_force`: so much has passed of what is needed. `good_frame`: its age, and
    /// the age that is allowed: the timeout, less the output's period if the frame has to last.
    Duration so_far{};
    Duration needed{};
    /// `run_frames`: the same in frames.
    std::uint64_t frames = 0;
    std::uint64_t needed_frames = 0;
    /// `release`: the condition, and the pulse of its channel, if that is present.
    ValueRule release_when{};
    std::optional<Pulse> pulse{};
};

}  // namespace tribus
