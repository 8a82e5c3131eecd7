#pragma once

#include <cstddef>
#include <regex>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/pages.h"

/// Examples of commands in pages, with what they print: a block of plain text whose lines after
/// `$ ` are commands, each with its output behind it. A line `...`, or ` ... ` in a line, stands
/// for anything.
namespace tribus::test {

struct PageExample {
    std::string where;  ///< name of the page, and line of the block
    std::string command;
    std::string output;
};

inline std::vector<PageExample> examples_in(const std::filesystem::path& page) {
    std::vector<PageExample> examples;
    for (const Fence& fence : fences_of(page)) {
        if (!fence.language.empty() || !fence.text.starts_with("$ ")) {
            continue;
        }
        std::istringstream lines(fence.text);
        for (std::string line; std::getline(lines, line);) {
            if (line.starts_with("$ ")) {
                examples.push_back({fence.where, line.substr(2), ""});
            } else {
                examples.back().output += line + "\n";
            }
        }
    }
    return examples;
}

/// The examples of `tribus` in all pages.
inline std::vector<PageExample> examples_of_the_program() {
    std::vector<PageExample> examples;
    for (const auto& page : manual_pages()) {
        for (const PageExample& example : examples_in(page)) {
            if (example.command.find("tribus ") != std::string::npos) {
                examples.push_back(example);
            }
        }
    }
    return examples;
}

/// Whether `got` has the parts of `shown` in their order, from its begin to its end.
inline bool has_parts(std::string_view shown, std::string_view got, std::string_view anything) {
    bool first = true;
    for (;;) {
        const std::size_t end = shown.find(anything);
        const std::string_view part = shown.substr(0, end);
        if (end == std::string_view::npos) {
            return first ? got == part : got.ends_with(part);
        }
        const std::size_t at = got.find(part);
        if (at == std::string_view::npos || (first && at != 0)) {
            return false;
        }
        got.remove_prefix(at + part.size());
        shown.remove_prefix(end + anything.size());
        first = false;
    }
}

/// Removes blanks at ends of lines.
inline std::string trimmed_lines(const std::string& text) {
    return std::regex_replace(text, std::regex(" +\n"), "\n");
}

/// Whether the program printed exactly what a page shows.
inline bool prints_exactly(const std::string& shown, const std::string& got) {
    // Anything within a line, and whole lines, end alike: with what follows.
    static const std::regex whole_line("(^|\n)\\.\\.\\.(?=\n)");
    const std::string marked =
        std::regex_replace(std::regex_replace(trimmed_lines(shown), whole_line, "$1\1"),
                           std::regex(" \\.\\.\\. +"), "\1");
    return has_parts(marked, trimmed_lines(got), "\1");
}

/// The words of an output: without numbers, times, places of files and the breaks of lines, which
/// differ from run to run.
inline std::string words_in(const std::string& text) {
    static const std::regex place(R"(/[A-Za-z0-9_./-]+)");
    static const std::regex fingerprint(R"(\b[0-9a-f]{4}(-[0-9a-f]{4}){3}\b|\b[0-9a-f]{16}\b)");
    static const std::regex number(R"([0-9]+([.:][0-9]+)*( ?(us|ms|s)\b)?)");
    static const std::regex blanks(R"(\s+)");
    std::string words = std::regex_replace(text, place, "/");
    words = std::regex_replace(words, fingerprint, "#");
    words = std::regex_replace(words, number, "#");
    return std::regex_replace(words, blanks, " ");
}

/// Whether the program printed the words that a page shows.
inline bool prints_the_words(const std::string& shown, const std::string& got) {
    return has_parts(words_in(shown), words_in(got), " ... ");
}

}  // namespace tribus::test
