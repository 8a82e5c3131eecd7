#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <tl/expected.hpp>

#include "transports/links/unique_fd.h"

/// The folder of a recording as one archive (POSIX.1-2017, pax, "ustar Interchange Format").
namespace tribus::web {

inline constexpr std::size_t kTarBlock = 512;

struct TarEntry {
    std::string name;
    std::uint64_t bytes = 0;
    std::int64_t changed = 0;  ///< seconds since 1970
};
/// The header before the content of a file: one block, or three if the name is longer than the
/// 100 bytes of a plain one. Pure.
std::string tar_header(const TarEntry& entry);
/// So many zero bytes fill the last block of a file. Pure.
std::size_t tar_padding(std::uint64_t bytes);

/// Reads the archive piece by piece. Holds one open folder, and one file while it is read.
/// Thread-bound.
class RecordingTar {
  public:
    /// Takes the regular files of that folder in `directory`; symbolic links are not followed. The
    /// error is a sentence.
    static tl::expected<RecordingTar, std::string> open(const std::filesystem::path& directory,
                                                        const std::string& name);

    std::uint64_t bytes() const { return bytes_; }
    /// The next piece, at most some ten thousand bytes; an empty one at the end. Nothing if a file
    /// is gone or shorter than it was. Waits as long as the disk does.
    std::optional<std::string> next();

  private:
    RecordingTar(UniqueFd folder, std::string name) : folder_(std::move(folder)), name_(name) {}
    tl::expected<void, std::string> list(const std::filesystem::path& folder);
    std::optional<std::string> begin_file();
    std::optional<std::string> read_more();

    UniqueFd folder_;
    std::string name_;
    std::vector<TarEntry> files_;
    std::uint64_t bytes_ = 0;
    std::size_t at_ = 0;  ///< index of the present file
    UniqueFd file_;
    std::uint64_t left_ = 0;  ///< bytes of the present file
    bool ended_ = false;
};

}  // namespace tribus::web
