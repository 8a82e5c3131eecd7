#pragma once

#include <string>
#include <string_view>

#include "app/cli/command.h"

/// Messages for command lines that cannot be used: what is wrong, and what is allowed. Pure.
namespace tribus {

std::string unknown_command(const Program& program, std::string_view word);
/// `command`: null if no command is named.
std::string unknown_option(const Program& program, const Command* command, std::string_view word);
std::string too_many_words(const Program& program, const Command& command, std::string_view word);
std::string missing_word(const Program& program, const Command* command, std::string_view name);
/// For an option whose number of values is wrong. `times`: how often it is given.
std::string wrong_count(const CommandOption& option, std::size_t times);

/// Why the text cannot be the value of the option; empty: it can.
std::string mistake_in_value(const CommandOption& option, const std::string& text);

}  // namespace tribus
