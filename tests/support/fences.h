#pragma once

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

/// README.md and the pages of docs/. Needs the compile definition TRIBUS_SOURCE_DIR.
namespace tribus::test {

inline std::string page_text(const std::filesystem::path& page) {
    std::ifstream file(page, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

inline std::filesystem::path readme() {
    return std::filesystem::path(TRIBUS_SOURCE_DIR) / "README.md";
}

/// README.md first, then docs/ by name.
inline std::vector<std::filesystem::path> manual_pages() {
    std::vector<std::filesystem::path> pages;
    const auto docs = std::filesystem::path(TRIBUS_SOURCE_DIR) / "docs";
    for (const auto& entry : std::filesystem::recursive_directory_iterator(docs)) {
        if (entry.path().extension() == ".md") {
            pages.push_back(entry.path());
        }
    }
    std::sort(pages.begin(), pages.end());
    pages.insert(pages.begin(), readme());
    return pages;
}

/// A block of a page between two lines of ```.
struct Fence {
    std::string where;     ///< name of the page, and line of the first ```
    std::string language;  ///< "toml", "sh", ...; empty for plain text
    std::string title;     ///< the last line in front of it that is not empty
    std::string text;
};

inline std::vector<Fence> fences_of(const std::filesystem::path& page) {
    std::istringstream lines(page_text(page));
    std::vector<Fence> fences;
    bool inside = false;
    std::string title;
    std::size_t number = 0;
    for (std::string line; std::getline(lines, line);) {
        ++number;
        const std::size_t mark = line.find_first_not_of(' ');
        if (mark != std::string::npos && line.compare(mark, 3, "```") == 0) {
            inside = !inside;
            if (inside) {
                const std::string where = page.filename().string() + ":" + std::to_string(number);
                fences.push_back({where, line.substr(mark + 3), title, ""});
            }
        } else if (inside) {
            fences.back().text += line + "\n";
        } else if (mark != std::string::npos) {
            title = line;
        }
    }
    return fences;
}

}  // namespace tribus::test
