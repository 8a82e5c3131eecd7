#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include <tl/expected.hpp>

#include "transports/links/unique_fd.h"

/// Memory for the rings of the flight recorder.
namespace tribus {

/// Memory whose pages are all present, so that the data thread never waits for one. Move-only.
class RingMemory {
  public:
    /// Memory of this process alone. The error is a sentence.
    static tl::expected<RingMemory, std::string> anonymous(std::size_t bytes);
    /// Memory in a new file, which survives a crash of the process. The error is a sentence.
    static tl::expected<RingMemory, std::string> in_file(const std::filesystem::path& path,
                                                         std::size_t bytes);
    /// A copy of a file's content. Refuses, without waiting, anything but a regular file of 1 to
    /// `most` bytes. The error is a sentence.
    static tl::expected<RingMemory, std::string> copy_of(const std::filesystem::path& path,
                                                         std::size_t most);

    RingMemory(RingMemory&& other) noexcept
        : begin_(std::exchange(other.begin_, nullptr)), bytes_(other.bytes_) {}
    RingMemory& operator=(RingMemory&& other) noexcept {
        std::swap(begin_, other.begin_);
        std::swap(bytes_, other.bytes_);
        return *this;
    }
    RingMemory(const RingMemory&) = delete;
    RingMemory& operator=(const RingMemory&) = delete;
    ~RingMemory();

    std::span<std::byte> span() const { return {begin_, bytes_}; }

  private:
    RingMemory(std::byte* begin, std::size_t bytes) : begin_(begin), bytes_(bytes) {}
    static tl::expected<RingMemory, std::string> map(int flags, int fd, std::size_t bytes);

    std::byte* begin_ = nullptr;
    std::size_t bytes_ = 0;
};

/// A folder in the service's runtime directory that only this process uses. Memory in its files
/// survives a crash; the next process reads it.
class RingDirectory {
  public:
    /// The error is a sentence; the recorder then uses anonymous memory, which a crash loses.
    static tl::expected<RingDirectory, std::string> open(
        const std::filesystem::path& runtime_directory);
    RingDirectory(RingDirectory&&) noexcept = default;
    RingDirectory& operator=(RingDirectory&&) noexcept = delete;
    ~RingDirectory();

    const std::filesystem::path& path() const { return path_; }
    /// The data of a crashed process, renamed first: if reading it crashes this process, the next
    /// one starts without it. Nothing if no data was left.
    std::optional<std::filesystem::path> take_left() const;
    /// Call it when the data was written or cannot be.
    void remove_left() const;
    /// Call it when the data could not be written now: the next process tries again.
    void put_left_back() const;

  private:
    RingDirectory(std::filesystem::path path, UniqueFd lock)
        : path_(std::move(path)), lock_(std::move(lock)) {}

    std::filesystem::path path_;
    UniqueFd lock_;
};

}  // namespace tribus
