#pragma once

namespace CLI {
class App;
}

namespace tribus {

/// The subcommand `monitor`: what a running daemon does.
void add_monitor_command(CLI::App& app, int& status);

}  // namespace tribus
