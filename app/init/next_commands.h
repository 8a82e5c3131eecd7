#pragma once

#include <string>
#include <string_view>
#include <vector>

/// The commands that `tribus init` proposes. Pure.
namespace tribus::init {

/// A word for a shell, in single quotes if necessary.
std::string shell_word(std::string_view text);

/// The text if it is printable ASCII, so that a comment can contain it; else `fallback`.
std::string printable_or(std::string_view text, std::string_view fallback);

/// The file name in the commands of its own comments; FILE if there is none that a comment can
/// contain.
std::string name_in_comments(std::string_view file);

/// Commands that check the configuration in `file`, study its input and run it, in this order: who
/// runs it first trusts a receiver whose failsafe nobody has seen.
std::vector<std::string> next_commands(std::string_view file, std::string_view input);

/// Commands that run it as a service.
std::vector<std::string> service_commands(std::string_view file);

}  // namespace tribus::init
