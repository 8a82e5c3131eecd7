#pragma once

#include <sstream>
#include <string>
#include <vector>

#include "tests/support/shell.h"

namespace tribus::test {

/// The commands that the help of a program lists.
inline std::vector<std::string> commands_of(const std::string& program) {
    const std::string help = run_in_shell("'" + program + "' --help").output;
    std::istringstream lines(help.substr(help.find("Commands:\n")));
    std::vector<std::string> names;
    std::string line;
    std::getline(lines, line);
    while (std::getline(lines, line) && line.starts_with("  ")) {
        if (line[2] != ' ') {
            names.push_back(line.substr(2, line.find(' ', 2) - 2));
        }
    }
    return names;
}

}  // namespace tribus::test
