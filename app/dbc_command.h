#pragma once

namespace CLI {
class App;
}

/// The subcommand `dbc`: the native CAN format as a DBC file, for other tools on the bus.
namespace tribus {

void add_dbc_command(CLI::App& app, int& status);

}  // namespace tribus
