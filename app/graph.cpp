#include "app/graph.h"

#include <memory>
#include <string>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "app/exit_status.h"
#include "app/graph_model.h"
#include "app/graph_picture.h"
#include "app/load_or_explain.h"

namespace tribus {

void add_graph_command(CLI::App& app, int& status) {
    auto* command = app.add_subcommand("graph", "Print a configuration as a picture");
    struct Options {
        std::string path;
        std::string format = "svg";
    };
    auto options = std::make_shared<Options>();
    command->add_option("CONFIG", options->path, "Configuration file")->required();
    command->add_option("--format", options->format, "svg, dot for Graphviz, mermaid for Markdown")
        ->check(CLI::IsMember({"svg", "dot", "mermaid"}))
        ->capture_default_str();
    command->footer("tribus graph servos.toml > servos.svg");
    command->callback([options, &status] {
        const auto configuration = load_or_explain(options->path);
        if (!configuration) {
            status = kExitWrongUse;
            return;
        }
        const Graph graph = graph_of(*configuration);
        fmt::print("{}", options->format == "dot"       ? graph_dot(graph)
                         : options->format == "mermaid" ? graph_mermaid(graph)
                                                        : graph_svg(graph));
    });
}

}  // namespace tribus
