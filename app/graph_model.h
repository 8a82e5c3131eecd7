#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "config/schema.h"

/// A configuration as boxes and arrows. Pure.
namespace tribus {

/// Where a box stands, from left to right.
enum class GraphColumn : std::uint8_t { sources, pipelines, outputs, lamps };
inline constexpr std::size_t kGraphColumns = 4;

struct GraphBox {
    GraphColumn column = GraphColumn::sources;
    std::string title;
    std::vector<std::string> lines;
};

/// From one box to another, by their places.
struct GraphArrow {
    std::size_t from = 0;
    std::size_t to = 0;
    std::string label;
    /// Of numbers and switches instead of channels.
    bool dashed = false;
};

struct Graph {
    std::vector<GraphBox> boxes;
    std::vector<GraphArrow> arrows;
};

/// In the order of the configuration, so that the same one gives the same graph.
Graph graph_of(const Configuration& configuration);

}  // namespace tribus
