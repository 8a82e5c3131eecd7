#pragma once

namespace CLI {
class App;
}

namespace tribus {

/// The subcommand `graph`: a configuration as a picture.
void add_graph_command(CLI::App& app, int& status);

}  // namespace tribus
