#include "tests/support/pages.h"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <map>
#include <regex>
#include <sstream>
#include <utility>

namespace tribus::test {

namespace fs = std::filesystem;

namespace {

/// Folders of a build, of tools, and of inputs that fuzzing made.
bool is_foreign(const fs::path& folder) {
    const std::string name = folder.filename().string();
    return (name.starts_with(".") && name != ".ci") || name.starts_with("build") ||
           name == "corpus" || name == "out" || name == "node_modules" ||
           fs::exists(folder / "CMakeCache.txt");
}

/// Removes fenced blocks, in which nothing is a heading or a link.
std::string without_fences(const std::string& page) {
    std::string text;
    bool fenced = false;
    for (std::size_t begin = 0; begin < page.size();) {
        const std::size_t end = std::min(page.find('\n', begin), page.size());
        const std::string line = page.substr(begin, end - begin);
        const std::size_t first = std::min(line.find_first_not_of(' '), line.size());
        const bool fence = std::string_view(line).substr(first).starts_with("```");
        fenced = fenced != fence;
        if (!fenced && !fence) {
            text += line;
        }
        text += '\n';
        begin = end + 1;
    }
    return text;
}

/// Removes the markup; a link becomes its text.
std::string plain(const std::string& markdown) {
    static const std::regex link_form(R"(\[([^\]]*)\]\([^)]*\))");
    std::string text = std::regex_replace(markdown, link_form, "$1");
    std::erase_if(text, [](char c) { return c == '`' || c == '*'; });
    return text;
}

/// The anchor that GitHub gives a heading: lower case, digits, hyphens; other characters are left
/// out.
std::string anchor_of(std::string_view heading) {
    std::string anchor;
    for (std::size_t i = 0; i < heading.size(); ++i) {
        const char c = heading[i];
        if (c == ' ') {
            anchor += '-';
        } else if (static_cast<unsigned char>(c) == 0xE2) {
            i += 2;  // dashes, quotes and arrows are three bytes
        } else if (std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '_' ||
                   static_cast<unsigned char>(c) >= 0x80) {
            anchor += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
        }
    }
    return anchor;
}

}  // namespace

std::vector<fs::path> project_files() {
    const fs::path root = fs::path(TRIBUS_SOURCE_DIR).lexically_normal();
    std::vector<fs::path> found;
    for (auto entry = fs::recursive_directory_iterator(root);
         entry != fs::recursive_directory_iterator(); ++entry) {
        if (entry->is_directory() && is_foreign(entry->path())) {
            entry.disable_recursion_pending();
        } else if (entry->is_regular_file()) {
            found.push_back(entry->path().lexically_relative(root));
        }
    }
    return found;
}

std::string source_text(const fs::path& file) {
    return text_of_file(fs::path(TRIBUS_SOURCE_DIR) / file);
}

std::string text_of_file(const fs::path& path) {
    std::ostringstream text;
    text << std::ifstream(path, std::ios::binary).rdbuf();
    return std::move(text).str();
}

fs::path readme() {
    return fs::path(TRIBUS_SOURCE_DIR) / "README.md";
}

std::vector<fs::path> manual_pages() {
    std::vector<fs::path> pages;
    const auto docs = fs::path(TRIBUS_SOURCE_DIR) / "docs";
    for (const auto& entry : fs::recursive_directory_iterator(docs)) {
        if (entry.path().extension() == ".md") {
            pages.push_back(entry.path());
        }
    }
    std::ranges::sort(pages);
    pages.insert(pages.begin(), readme());
    return pages;
}

std::vector<Fence> fences_of(const fs::path& page) {
    std::istringstream lines(text_of_file(page));
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

std::vector<std::string> headings_in(const std::string& page) {
    static const std::regex heading_form("#{1,6} +(.*[^# ])[# ]*");
    std::istringstream lines(without_fences(page));
    std::vector<std::string> headings;
    std::smatch heading;
    for (std::string line; std::getline(lines, line);) {
        if (line.starts_with('#') && std::regex_match(line, heading, heading_form)) {
            headings.push_back(plain(heading[1]));
        }
    }
    return headings;
}

/// A heading that comes again gets a number.
std::set<std::string> anchors_in(const std::string& page) {
    constexpr std::string_view kOwnAnchor = "<a id=\"";
    std::map<std::string, int> times;
    std::set<std::string> anchors;
    for (const std::string& heading : headings_in(page)) {
        const std::string anchor = anchor_of(heading);
        const int before = times[anchor]++;
        anchors.insert(before == 0 ? anchor : anchor + "-" + std::to_string(before));
    }
    const std::string text = without_fences(page);
    for (std::size_t at = text.find(kOwnAnchor); at != std::string::npos;
         at = text.find(kOwnAnchor, at)) {
        at += kOwnAnchor.size();
        anchors.insert(text.substr(at, text.find('"', at) - at));
    }
    return anchors;
}

std::vector<std::string> links_in(const std::string& page) {
    static const std::regex inline_code("``[^\n]*?``|`[^`\n]*`");
    static const std::regex link_form(R"(\]\(\s*<?([^)\s>]+)>?(?:\s+"[^"]*")?\s*\))");
    const std::string text = std::regex_replace(without_fences(page), inline_code, "");
    std::vector<std::string> targets;
    for (std::sregex_iterator match(text.begin(), text.end(), link_form), none; match != none;
         ++match) {
        targets.push_back((*match)[1]);
    }
    return targets;
}

std::optional<std::string> dead_link(const fs::path& root, const fs::path& page,
                                     const std::string& target) {
    if (target.find("://") != std::string::npos || target.starts_with("mailto:")) {
        return std::nullopt;
    }
    const std::size_t hash = std::min(target.find('#'), target.size());
    const std::string file = target.substr(0, hash);
    const fs::path path = file.empty() ? page : (page.parent_path() / file).lexically_normal();
    if (path.is_absolute() || path.string().starts_with("..") || !fs::exists(root / path)) {
        return target + ": there is no such file";
    }
    const bool has_anchor = hash < target.size() && path.extension() == ".md";
    if (has_anchor && !anchors_in(text_of_file(root / path)).contains(target.substr(hash + 1))) {
        return target + ": that page has no such heading";
    }
    return std::nullopt;
}

}  // namespace tribus::test
