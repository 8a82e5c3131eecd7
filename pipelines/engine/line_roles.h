#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/time.h"
#include "pipelines/engine/output.h"
#include "pipelines/rules/line_words.h"
#include "pipelines/rules/settings.h"

namespace tribus {

/// What GPIO lines demand of outputs, and what outputs show on lines. Knows neither chips nor
/// voltage levels. Thread-bound. No allocation after construction.
class LineRoles {
  public:
    explicit LineRoles(std::vector<LineTask> tasks) : tasks_(std::move(tasks)) {}

    /// Whether a line forces that output into failsafe: it is active or cannot be read, because a
    /// broken wire or a removed chip must lead to failsafe.
    bool forces(std::size_t output, LineLevels levels) const;
    /// Index in `inputs` of the selected input: that of the first active line, in the order of the
    /// configuration, whose input is in the list. A line that cannot be read selects nothing.
    std::optional<std::size_t> picked(std::span<const std::size_t> inputs, LineLevels levels) const;
    /// What each output line shows, except the waves of `fresh`.
    LineStates shown(std::span<const Output> outputs) const;

  private:
    std::vector<LineTask> tasks_;
};

/// Whether the frame that the output has just handed over keeps a `fresh` line going: an input is
/// in control, the frame is not marked, and it left at most half a period after it was due. A
/// requested failsafe (a switch, another node, the end of the program) ends the wave as any other
/// failsafe does.
bool is_fresh(const Output& output, Instant handed_over);

}  // namespace tribus
