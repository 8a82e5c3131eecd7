#pragma once

namespace CLI {
class App;
}

namespace tribus {

/// The subcommand `bench`: what the appliance adds on this machine, beside the least that any
/// program would.
void add_bench_command(CLI::App& app, int& status);

}  // namespace tribus
