#pragma once

namespace CLI {
class App;
}

namespace tribus {

/// The subcommands `check` (validates a configuration) and `schema` (prints its JSON schema).
void add_check_command(CLI::App& app, int& status);
void add_schema_command(CLI::App& app);

}  // namespace tribus
