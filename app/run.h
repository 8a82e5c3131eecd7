#pragma once

namespace CLI {
class App;
}

namespace tribus {

/// The subcommand `run`: the daemon, in the foreground.
void add_run_command(CLI::App& app, int& status);

}  // namespace tribus
