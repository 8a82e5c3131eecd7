#pragma once

#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

/// Contents and links of pages in Markdown, such as README.md and docs/. Needs the compile
/// definition TRIBUS_SOURCE_DIR.
namespace tribus::test {

std::string text_of_file(const std::filesystem::path& path);

/// `file`: relative to the project.
std::string source_text(const std::filesystem::path& file);

/// All files of the project, relative to it; not those of a build or a tool.
std::vector<std::filesystem::path> project_files();

std::filesystem::path readme();

/// README.md first, then docs/ by name.
std::vector<std::filesystem::path> manual_pages();

/// A block of a page between two lines of ```.
struct Fence {
    std::string where;     ///< name of the page, and line of the first ```
    std::string language;  ///< "toml", "sh", ...; empty for plain text
    std::string title;     ///< the last line before it that is not empty
    std::string text;
};

std::vector<Fence> fences_of(const std::filesystem::path& page);

/// The headings without markup.
std::vector<std::string> headings_in(const std::string& page);

/// Anchors that GitHub gives the headings, and anchors of the page itself: `<a id="name"></a>`.
std::set<std::string> anchors_in(const std::string& page);

/// Targets of the links `[text](target)` and `[text](target#anchor)`; not those in code.
std::vector<std::string> links_in(const std::string& page);

/// Why a link of a page leads nowhere below `root`; nothing if it leads somewhere, or out to the
/// net. `page` is relative to `root`.
std::optional<std::string> dead_link(const std::filesystem::path& root,
                                     const std::filesystem::path& page, const std::string& target);

}  // namespace tribus::test
