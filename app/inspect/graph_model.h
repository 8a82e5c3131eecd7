#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "config/schema/schema.h"

/// A configuration as boxes and arrows. Pure.
namespace tribus {

/// Column of a box, from left to right.
enum class GraphColumn : std::uint8_t { sources, pipelines, outputs, lines };
inline constexpr std::size_t kGraphColumns = 4;

struct GraphBox {
    GraphColumn column = GraphColumn::sources;
    std::string title;
    std::vector<std::string> lines;
};

/// An arrow between two boxes, given by their indices.
struct GraphArrow {
    std::size_t from = 0;
    std::size_t to = 0;
    std::string label;
    /// Carries numbers or switches instead of channels.
    bool dashed = false;
};

struct Graph {
    std::vector<GraphBox> boxes;
    std::vector<GraphArrow> arrows;
};

/// In the order of the configuration, so that equal configurations give equal graphs.
Graph graph_of(const Configuration& configuration);

}  // namespace tribus
