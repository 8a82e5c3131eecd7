#pragma once

#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

/// What pages in Markdown have, and whether their links lead somewhere.
namespace tribus::test {

std::string text_of_file(const std::filesystem::path& path);

/// As a reader sees them.
std::vector<std::string> headings_in(const std::string& page);

/// Of headings as GitHub makes them, and those that the page sets itself: `<a id="name"></a>`.
std::set<std::string> anchors_in(const std::string& page);

/// Targets of the links `[text](target)` and `[text](target#anchor)`; not those in code.
std::vector<std::string> links_in(const std::string& page);

/// Why a link of a page leads nowhere below `root`; nothing if it leads somewhere, or out to the
/// net. `page` is relative to `root`.
std::optional<std::string> dead_link(const std::filesystem::path& root,
                                     const std::filesystem::path& page, const std::string& target);

}  // namespace tribus::test
