#pragma once

namespace CLI {
class App;
}

namespace tribus {

/// `tribus record`: a recording of the flight recorder of a running daemon, or of a port by itself.
void add_record_command(CLI::App& app, int& status);

}  // namespace tribus
