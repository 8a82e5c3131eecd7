#pragma once

namespace CLI {
class App;
}

namespace tribus {

/// The subcommand `doctor`: what this machine's ports can do, what they hear, and what to mend.
void add_doctor_command(CLI::App& app, int& status);

}  // namespace tribus
