#pragma once

#include <string>
#include <string_view>

#include "app/cli/command.h"

/// The texts of `--help`: at most 80 columns. Pure.
namespace tribus {

std::string help_of(const Program& program);
std::string help_of(const Program& program, const Command& command);

/// The options that `value` selects, such as the settings of a protocol. The command has such
/// options for that value.
std::string help_of_selected(const Program& program, const Command& command,
                             std::string_view value);

/// `tribus diff [OPTIONS] CONFIG [NEW]`; `given` stands behind the command.
std::string usage_of(const Program& program, const Command& command, std::string_view given = {});

/// What is written behind an option: `FILE`, `text|json`; empty for a flag.
std::string value_text(const CommandOption& option);

}  // namespace tribus
