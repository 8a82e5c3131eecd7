#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include <tl/expected.hpp>

#include "transports/links/unique_fd.h"

/// Where the rings of the flight recorder live.
namespace tribus {

/// Pages that are there already: the data thread never waits for one. Move-only.
class RingMemory {
  public:
    /// Of this process alone.
    static tl::expected<RingMemory, std::string> anonymous(std::size_t bytes);
    /// A fresh file, which stays when the process ends otherwise than by itself.
    static tl::expected<RingMemory, std::string> in_file(const std::filesystem::path& path,
                                                         std::size_t bytes);
    /// What is in a file; changes do not reach it. Anything else than a file of 1 to `most` bytes
    /// is refused, and never waited for.
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

/// A folder of the service's runtime directory that this process alone uses: memory in its files
/// outlives a crash, for the process that comes next.
class RingHome {
  public:
    /// The error is a sentence: without a home memory is anonymous, and a crash loses it.
    static tl::expected<RingHome, std::string> open(const std::filesystem::path& runtime_directory);
    RingHome(RingHome&&) noexcept = default;
    RingHome& operator=(RingHome&&) noexcept = delete;
    ~RingHome();

    const std::filesystem::path& path() const { return path_; }
    /// What the process before left, under a name at which nobody looks again: should reading it
    /// end this process, the next one starts all the same. Nothing where it left nothing.
    std::optional<std::filesystem::path> take_left() const;
    /// It has been written, or cannot be.
    void remove_left() const;
    /// It could not be written just now: the next process takes it.
    void put_left_back() const;

  private:
    RingHome(std::filesystem::path path, UniqueFd lock)
        : path_(std::move(path)), lock_(std::move(lock)) {}

    std::filesystem::path path_;
    UniqueFd lock_;
};

}  // namespace tribus
