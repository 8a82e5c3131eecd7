#pragma once

#include <string>

#include "app/inspect/graph_model.h"

/// Boxes and arrows in picture formats. Pure; equal graphs give equal text.
namespace tribus {

/// Self-contained: needs no other file or font.
std::string graph_svg(const Graph& graph);
/// For `dot` of Graphviz.
std::string graph_dot(const Graph& graph);
/// For Markdown that shows mermaid diagrams.
std::string graph_mermaid(const Graph& graph);

}  // namespace tribus
