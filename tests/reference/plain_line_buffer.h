#pragma once

#include <algorithm>
#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <span>

namespace tribus::reference {

/// The bytes that a decoder has not judged yet, with their position in the whole stream. Bytes that
/// the line damaged are marked. The capacity is fixed; the caller must not add more than `room()`.
template <std::size_t Capacity>
class PlainLineBuffer {
  public:
    std::size_t size() const { return size_; }
    std::size_t room() const { return Capacity - size_; }
    std::uint8_t operator[](std::size_t position) const { return bytes_[position]; }
    std::span<const std::uint8_t> view(std::size_t start, std::size_t count) const {
        return std::span(bytes_).subspan(start, count);
    }

    bool damaged(std::size_t position) const { return damaged_[position]; }
    bool damaged(std::size_t start, std::size_t count) const {
        if (damaged_.none()) {
            return false;
        }
        for (std::size_t position = start; position < start + count; ++position) {
            if (damaged_[position]) {
                return true;
            }
        }
        return false;
    }

    void append(std::span<const std::uint8_t> bytes) {
        std::copy(bytes.begin(), bytes.end(), bytes_.begin() + static_cast<std::ptrdiff_t>(size_));
        size_ += bytes.size();
    }
    void append_damaged() {
        bytes_[size_] = 0;
        damaged_[size_] = true;
        ++size_;
    }

    /// Moves up to `count` bytes from the front of `bytes` into the buffer.
    void take(std::span<const std::uint8_t>& bytes, std::size_t count) {
        const std::size_t taken = std::min(count, bytes.size());
        append(bytes.first(taken));
        bytes = bytes.subspan(taken);
    }

    void drop(std::size_t count) {
        std::copy(bytes_.begin() + static_cast<std::ptrdiff_t>(count),
                  bytes_.begin() + static_cast<std::ptrdiff_t>(size_), bytes_.begin());
        damaged_ >>= count;
        size_ -= count;
        first_position_ += count;
    }

    /// Position in the stream of the byte at index 0.
    std::uint64_t first_position() const { return first_position_; }

  private:
    std::array<std::uint8_t, Capacity> bytes_{};
    std::bitset<Capacity> damaged_{};
    std::size_t size_ = 0;
    std::uint64_t first_position_ = 0;
};

}  // namespace tribus::reference
