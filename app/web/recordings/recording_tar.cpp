#include "app/web/recordings/recording_tar.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <numeric>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "app/cli/file_error.h"

namespace tribus::web {
namespace {

constexpr std::size_t kPieceBytes = std::size_t{32} * 1024;
constexpr std::size_t kMostFiles = 256;
/// Eleven octal digits can say no more.
constexpr std::uint64_t kMostFileBytes = (std::uint64_t{1} << 33U) - 1;
/// Two blocks of zeros end an archive.
constexpr std::size_t kArchiveEnd = 2 * kTarBlock;

/// A header is a block of texts at fixed places.
class TarBlock {
  public:
    void put(std::size_t place, std::size_t room, std::string_view text) {
        std::copy_n(text.begin(), std::min(room, text.size()),
                    block_.begin() + static_cast<std::ptrdiff_t>(place));
    }
    std::string with_checksum() {
        constexpr std::size_t kPlace = 148;
        constexpr std::size_t kRoom = 8;
        put(kPlace, kRoom, "        ");
        const unsigned sum = std::accumulate(
            block_.begin(), block_.end(), 0U,
            [](unsigned before, char byte) { return before + static_cast<unsigned char>(byte); });
        put(kPlace, kRoom, fmt::format("{:06o}", sum) + std::string(1, '\0'));
        return block_;
    }

  private:
    std::string block_ = std::string(kTarBlock, '\0');
};

constexpr std::size_t kNameRoom = 100;

/// `kind`: '0' for a file, 'x' for what a plain header has no room for.
std::string plain_tar_header(const TarEntry& entry, char kind) {
    TarBlock block;
    block.put(0, kNameRoom, entry.name);
    block.put(100, 8, "0000644");
    block.put(108, 8, "0000000");
    block.put(116, 8, "0000000");
    block.put(124, 12, fmt::format("{:011o}", entry.bytes));
    block.put(136, 12, fmt::format("{:011o}", std::max<std::int64_t>(entry.changed, 0)));
    block.put(156, 1, std::string(1, kind));
    block.put(257, 8, std::string("ustar\00000", 8));
    return block.with_checksum();
}

/// `27 path=NAME` and a line end; the number counts all bytes of it, also its own.
std::string pax_path(std::string_view name) {
    const std::string rest = fmt::format(" path={}\n", name);
    std::size_t length = rest.size() + 1;
    while (std::to_string(length).size() + rest.size() != length) {
        ++length;
    }
    return std::to_string(length) + rest;
}

UniqueFd open_plain_file(const UniqueFd& folder, const std::string& name) {
    // Opening a pipe would wait for its other side.
    return UniqueFd(
        ::openat(folder.get(), name.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
}

}  // namespace

std::size_t tar_padding(std::uint64_t bytes) {
    return static_cast<std::size_t>((kTarBlock - bytes % kTarBlock) % kTarBlock);
}

std::string tar_header(const TarEntry& entry) {
    if (entry.name.size() <= kNameRoom) {
        return plain_tar_header(entry, '0');
    }
    const std::string path = pax_path(entry.name);
    return plain_tar_header({.name = "PaxHeaders/" + entry.name.substr(0, kNameRoom / 2),
                             .bytes = path.size(),
                             .changed = entry.changed},
                            'x') +
           path + std::string(tar_padding(path.size()), '\0') + plain_tar_header(entry, '0');
}

tl::expected<RecordingTar, std::string> RecordingTar::open(const std::filesystem::path& directory,
                                                           const std::string& name) {
    const std::filesystem::path path = directory / name;
    UniqueFd folder(::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
    if (!folder.valid()) {
        return file_error(path, errno);
    }
    RecordingTar tar(std::move(folder), name);
    if (auto listed = tar.list(path); !listed) {
        return tl::unexpected(listed.error());
    }
    return tar;
}

tl::expected<void, std::string> RecordingTar::list(const std::filesystem::path& folder) {
    std::error_code error;
    for (std::filesystem::directory_iterator at(folder, error), end; !error && at != end;
         at.increment(error)) {
        const std::string file = at->path().filename().string();
        struct stat told {};
        if (::fstatat(folder_.get(), file.c_str(), &told, AT_SYMLINK_NOFOLLOW) != 0 ||
            !S_ISREG(told.st_mode)) {
            continue;
        }
        const auto bytes = static_cast<std::uint64_t>(told.st_size);
        if (files_.size() == kMostFiles || bytes > kMostFileBytes) {
            return tl::unexpected(
                fmt::format("{}: that is no recording of tribus", folder.string()));
        }
        files_.push_back({.name = file, .bytes = bytes, .changed = told.st_mtim.tv_sec});
    }
    if (error) {
        return tl::unexpected(fmt::format("{}: {}", folder.string(), error.message()));
    }
    std::ranges::sort(files_, {}, &TarEntry::name);
    bytes_ = kArchiveEnd;
    for (TarEntry& file : files_) {
        TarEntry shown = file;
        shown.name = name_ + "/" + file.name;
        bytes_ += tar_header(shown).size() + file.bytes + tar_padding(file.bytes);
    }
    return {};
}

std::optional<std::string> RecordingTar::begin_file() {
    TarEntry shown = files_[at_];
    file_ = open_plain_file(folder_, shown.name);
    struct stat told {};
    if (!file_.valid() || ::fstat(file_.get(), &told) != 0 || !S_ISREG(told.st_mode)) {
        return std::nullopt;
    }
    left_ = shown.bytes;
    shown.name = name_ + "/" + shown.name;
    return tar_header(shown);
}

/// Fills the last block behind the last byte.
std::optional<std::string> RecordingTar::read_more() {
    const std::uint64_t bytes = std::min<std::uint64_t>(kPieceBytes, left_);
    std::string piece(static_cast<std::size_t>(bytes), '\0');
    const ssize_t count = ::read(file_.get(), piece.data(), piece.size());
    if (count <= 0) {
        return std::nullopt;
    }
    piece.resize(static_cast<std::size_t>(count));
    left_ -= static_cast<std::uint64_t>(count);
    if (left_ == 0) {
        piece.append(tar_padding(files_[at_].bytes), '\0');
    }
    return piece;
}

std::optional<std::string> RecordingTar::next() {
    if (file_.valid() && left_ > 0) {
        return read_more();
    }
    if (file_.valid()) {
        file_.reset();
        ++at_;
    }
    if (at_ < files_.size()) {
        return begin_file();
    }
    return std::exchange(ended_, true) ? std::string() : std::string(kArchiveEnd, '\0');
}

}  // namespace tribus::web
