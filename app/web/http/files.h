#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <tl/expected.hpp>

/// The files of the page, and the configurations that it changes. Errors are sentences.
namespace tribus::web {

/// A file of the page, as it is sent.
struct PageFile {
    std::string_view type;
    std::string content;
    std::string gzip;  ///< empty: only as it is
};

/// All files of the page, by path: `/` is the page itself. Read once, at the start. Empty if there
/// is no such folder.
class PageFiles {
  public:
    static PageFiles read(const std::filesystem::path& folder);
    /// Null if there is none.
    const PageFile* find(std::string_view path) const;
    bool empty() const { return files_.empty(); }

  private:
    std::map<std::string, PageFile, std::less<>> files_;
};

/// Replaces the file by this text as a whole, also if the power fails. The old text goes to
/// `history`, of which the newest kMostKept stay.
tl::expected<void, std::string> keep_configuration(const std::filesystem::path& file,
                                                   std::string_view text,
                                                   const std::filesystem::path& history);
/// Its first half: the file has its old text until the daemon puts the successor in its place.
tl::expected<void, std::string> write_next_configuration(const std::filesystem::path& file,
                                                         std::string_view text,
                                                         const std::filesystem::path& history);
inline constexpr std::size_t kMostKept = 20;

/// A configuration of before.
struct KeptFile {
    std::string id;  ///< its time, such as 2026-11-26T04-10-00Z
    std::uintmax_t bytes = 0;
};
/// The newest first.
std::vector<KeptFile> kept_files(const std::filesystem::path& history);

}  // namespace tribus::web
