#include "app/help_formatter.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace tribus {
namespace {

constexpr std::size_t kColumns = 80;

/// Under the text of an option, or under the beginning of any other line.
std::size_t indent_of(std::string_view line, std::size_t column_width) {
    const std::size_t begin = std::min(line.find_first_not_of(' '), line.size());
    constexpr std::size_t kOfOptions = 2;
    return begin == kOfOptions ? column_width : begin;
}

void append_broken(std::string& text, std::string line, std::size_t column_width) {
    const std::size_t indent = indent_of(line, column_width);
    while (line.size() > kColumns) {
        std::size_t end = line.rfind(' ', kColumns);
        if (end == std::string::npos || line.find_last_not_of(' ', end) == std::string::npos ||
            line.find_last_not_of(' ', end) < indent) {
            end = line.find(' ', kColumns);
        }
        if (end == std::string::npos) {
            break;
        }
        text += line.substr(0, end) + '\n';
        line = std::string(indent, ' ') + line.substr(end + 1);
    }
    text += line;
}

}  // namespace

std::string HelpFormatter::make_help(const CLI::App* app, std::string name,
                                     CLI::AppFormatMode mode) const {
    const std::string whole = CLI::Formatter::make_help(app, std::move(name), mode);
    std::string text;
    for (std::size_t begin = 0; begin < whole.size();) {
        const std::size_t end = std::min(whole.find('\n', begin), whole.size());
        append_broken(text, whole.substr(begin, end - begin), column_width_);
        text += end < whole.size() ? "\n" : "";
        begin = end + 1;
    }
    return text;
}

std::string choices_type(std::string_view words) {
    std::string text = "TEXT:{";
    std::ranges::remove_copy(words, std::back_inserter(text), ' ');
    return text + '}';
}

}  // namespace tribus
