#pragma once

namespace CLI {
class App;
}

namespace tribus {

/// The subcommand `simulate`: a configuration over recorded inputs, in virtual time.
void add_simulate_command(CLI::App& app, int& status);

}  // namespace tribus
