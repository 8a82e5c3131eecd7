#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/cli/command.h"

/// The helper that opens ports for the page's server, which has none. It is a process for each
/// request, and knows two verbs: doctor and learn.
namespace tribus::web {

/// The command `ports` of tribus-web: reads a request in one line of standard input and becomes the
/// program that does it. Standard input and output are the connection.
Command ports_command();

/// The arguments of `tribus` for a request: `{"verb":"doctor","device","seconds"}` or
/// `{"verb":"learn","daemon","input"}`. Nothing if the request asks for anything else. Pure.
std::optional<std::vector<std::string>> program_for(std::string_view request,
                                                    const std::filesystem::path& configurations);

}  // namespace tribus::web
