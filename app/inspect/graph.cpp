#include "app/inspect/graph.h"

#include <memory>
#include <string>

#include <fmt/format.h>

#include "app/cli/exit_status.h"
#include "app/cli/load_or_explain.h"
#include "app/inspect/graph_model.h"
#include "app/inspect/graph_picture.h"

namespace tribus {

namespace {

struct GraphOptions {
    std::string path;
    std::string format = "svg";
};

int print_graph(const GraphOptions& options) {
    const auto configuration = load_or_explain(options.path);
    if (!configuration) {
        return kExitWrongUse;
    }
    const Graph graph = graph_of(*configuration);
    fmt::print("{}", options.format == "dot"       ? graph_dot(graph)
                     : options.format == "mermaid" ? graph_mermaid(graph)
                                                   : graph_svg(graph));
    return kExitFine;
}

}  // namespace

Command graph_command() {
    auto options = std::make_shared<GraphOptions>();
    return {
        .name = "graph",
        .help = "Print a configuration as a picture",
        .options = {configuration_option(options->path),
                    {.name = "--format",
                     .value = &options->format,
                     .help = "svg, dot for Graphviz, mermaid for Markdown",
                     .shows_value = true,
                     .choices = {"svg", "dot", "mermaid"}}},
        .examples = {{"tribus graph servos.toml > servos.svg", ""},
                     {"tribus graph --format dot servos.toml | dot -Tpng > servos.png", ""}},
        .run = [options] { return print_graph(*options); },
    };
}

}  // namespace tribus
