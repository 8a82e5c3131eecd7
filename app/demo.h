#pragma once

namespace CLI {
class App;
}

namespace tribus {

/// The subcommand `demo`: the main job with nothing attached, over real ttys.
void add_demo_command(CLI::App& app, int& status);

}  // namespace tribus
