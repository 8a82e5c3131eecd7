#pragma once

#include <string>

#include "app/graph_model.h"

/// Boxes and arrows as pictures of a known form. Pure; the same graph gives the same text.
namespace tribus {

/// Complete: needs no other file and no font of its own.
std::string graph_svg(const Graph& graph);
/// For `dot` of Graphviz.
std::string graph_dot(const Graph& graph);
/// For Markdown that shows mermaid diagrams.
std::string graph_mermaid(const Graph& graph);

}  // namespace tribus
