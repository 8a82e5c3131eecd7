#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/time.h"
#include "pipelines/line_words.h"
#include "pipelines/output.h"
#include "pipelines/settings.h"

namespace tribus {

/// What lines ask of the outputs, and what outputs show on lines. Knows no chip and no level on a
/// wire. Thread-bound; no allocation after construction.
class LineRoles {
  public:
    explicit LineRoles(std::vector<LineTask> tasks) : tasks_(std::move(tasks)) {}

    /// A line that forces that output into failsafe is active, or cannot be read: who pulls its
    /// wire or its chip out asks for failsafe.
    bool forces(std::size_t output, LineLevels levels) const;
    /// The place among `inputs` of the one that a person picks: by the first active line, in the
    /// order of the configuration, whose input is there. One that cannot be read picks nothing.
    std::optional<std::size_t> picked(std::span<const std::size_t> inputs, LineLevels levels) const;
    /// What each output line shows, but for the waves of `fresh`.
    LineStates shown(std::span<const Output> outputs) const;

  private:
    std::vector<LineTask> tasks_;
};

/// Whether the frame that an output has just handed over is what a `fresh` line vouches for: an
/// input in control, not marked, and not later than half an output's period after it was due. A
/// failsafe that is meant (a switch, another node, the end of the program) ends the wave as any
/// other does: what it sends is no data.
bool is_fresh(const Output& output, Instant handed_over);

}  // namespace tribus
