#pragma once

namespace CLI {
class App;
}

namespace tribus {

/// `tribus replay`: a recording into a pseudo-terminal, a serial device or a CAN interface, with
/// its timing.
void add_replay_command(CLI::App& app, int& status);

}  // namespace tribus
