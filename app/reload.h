#pragma once

namespace CLI {
class App;
}

namespace tribus {

/// The subcommand `reload`.
void add_reload_command(CLI::App& app, int& status);

}  // namespace tribus
