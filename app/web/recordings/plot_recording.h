#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <ostream>
#include <string>
#include <string_view>
#include <vector>

#include <tl/expected.hpp>

#include "app/web/recordings/plot_curve.h"
#include "core/time.h"

/// A recording of the flight recorder as a picture needs it.
namespace tribus::web {

/// Times count from the beginning of the recording.
struct PlotOrder {
    Duration from{};
    Duration to{};
    std::size_t columns = 0;
};

struct PlotSeries {
    std::string name;
    std::string_view kind;  ///< "input" or "output"
    PlotFrames frames;
};

struct PlottedStates {
    std::string output;
    PlotStates states;
};

struct RecordingPlot {
    PlotSpan span;
    Duration length{};  ///< of the whole recording
    std::vector<PlotSeries> series;
    std::vector<PlottedStates> states;
    /// The place of the damage in a recording of which the plot has only what could be read.
    std::optional<std::string> problem;
};

/// Reads the recording in `folder`. Inputs and outputs have the values that passed the ports. The
/// states of the outputs are not in a recording: they come from its configuration, run over its
/// inputs in virtual time; they are "unknown" until what happened before the recording no longer
/// matters. Follows no symbolic link. The error is a sentence.
tl::expected<RecordingPlot, std::string> plot_recording(const std::filesystem::path& folder,
                                                        const PlotOrder& order);

/// Writes it as JSON (docs/web.md).
void write_plot(const RecordingPlot& plot, std::ostream& out);

}  // namespace tribus::web
