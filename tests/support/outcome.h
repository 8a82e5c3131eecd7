#pragma once

#include <ostream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

/// Runs a command in the test and keeps what it wrote to its two streams.
namespace tribus::test {

struct Outcome {
    int status = -1;
    std::string results;
    std::string messages;

    std::vector<std::string> lines() const {
        std::vector<std::string> lines;
        std::istringstream text(results);
        for (std::string line; std::getline(text, line);) {
            lines.push_back(line);
        }
        return lines;
    }
};

/// Calls `command(results, messages)`, which returns the exit status.
template <class Command>
Outcome outcome_of(Command command) {
    std::ostringstream results;
    std::ostringstream messages;
    const int status = command(results, messages);
    return {status, std::move(results).str(), std::move(messages).str()};
}

}  // namespace tribus::test
