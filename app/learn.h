#pragma once

namespace CLI {
class App;
}

namespace tribus {

/// The subcommand `learn`: which detectors recognise the loss of a receiver's link.
void add_learn_command(CLI::App& app, int& status);

}  // namespace tribus
