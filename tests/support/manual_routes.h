#pragma once

#include <fstream>
#include <regex>
#include <string>
#include <vector>

/// The table of addresses in docs/web.md, without queries. Needs the compile definition
/// TRIBUS_SOURCE_DIR.
namespace tribus::test {

struct ManualRoute {
    std::string method;
    std::string path;  ///< with the manual's N, ID and NUMBER
    std::string who;
};

inline std::vector<ManualRoute> manual_routes() {
    std::ifstream manual(TRIBUS_SOURCE_DIR "/docs/web.md");
    // | `GET /api/N/history/ID` | looks | ... |
    const std::regex row(R"(\| `(GET|POST) (/[^`?]*)[^|]*\| (\w+) \|.*)");
    std::vector<ManualRoute> all;
    for (std::string line; std::getline(manual, line);) {
        std::smatch parts;
        if (std::regex_match(line, parts, row)) {
            all.push_back({parts[1], parts[2], parts[3]});
        }
    }
    return all;
}

}  // namespace tribus::test
