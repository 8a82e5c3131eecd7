#include "config/show/manual_text.h"

#include <algorithm>

namespace tribus {
namespace {

constexpr std::string_view kFence = "```";
constexpr std::string_view kItem = "- ";

std::string_view take_line(std::string_view& text) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    return line;
}

void add_words(std::string& text, std::string_view line) {
    text += text.empty() ? "" : " ";
    text += line;
}

}  // namespace

std::vector<ManualBlock> blocks_of(std::string_view text) {
    std::vector<ManualBlock> blocks;
    bool goes_on = false;
    bool fenced = false;
    while (!text.empty()) {
        const std::string_view line = take_line(text);
        if (line.starts_with(kFence)) {
            fenced = !fenced;
            goes_on = false;
            if (fenced) {
                blocks.push_back({BlockKind::code, {}});
            }
        } else if (fenced) {
            blocks.back().texts.emplace_back(line);
        } else if (line.empty()) {
            goes_on = false;
        } else if (line.starts_with(kItem)) {
            if (!goes_on) {
                blocks.push_back({BlockKind::list, {}});
            }
            blocks.back().texts.emplace_back(line.substr(kItem.size()));
            goes_on = true;
        } else if (goes_on) {
            const std::size_t begin = std::min(line.find_first_not_of(' '), line.size());
            add_words(blocks.back().texts.back(), line.substr(begin));
        } else {
            blocks.push_back({BlockKind::paragraph, {std::string(line)}});
            goes_on = true;
        }
    }
    return blocks;
}

std::string replaced(std::string text, std::string_view from, std::string_view to) {
    for (std::size_t at = text.find(from); at != std::string::npos;
         at = text.find(from, at + to.size())) {
        text.replace(at, from.size(), to);
    }
    return text;
}

}  // namespace tribus
