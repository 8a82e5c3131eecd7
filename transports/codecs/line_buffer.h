#pragma once

#include <algorithm>
#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <span>

namespace tribus {

/// The bytes that a decoder has not judged yet, each with a mark if the line damaged it, and their
/// place in the whole stream.
///
/// While a decoder works on a read, they stand where the read put them; only what outlasts the read
/// is copied. A decoder sees no more bytes than it asked for, so what it finds does not depend on
/// how the stream is cut into reads. Thread-bound; no heap.
class LineBuffer {
  public:
    /// No decoder asks for more bytes at once, or leaves more.
    static constexpr std::size_t kCapacity = 128;

    /// Between two reads: if the decoder waits for more bytes than with these, keeps them all and
    /// says so.
    bool keep(std::span<const std::uint8_t> bytes) {
        if (bytes.size() >= missing_) {
            return false;
        }
        if (bytes.size() == 1) {
            kept_[size_] = bytes.front();
            ++size_;
            --missing_;
        } else if (!bytes.empty()) {
            keep_all(bytes);
        }
        return true;
    }
    /// Between two reads: a byte stood here that cannot be read.
    void append_damaged() {
        kept_[size_] = 0;
        damaged_[size_] = true;
        ++size_;
        missing_ = 0;
    }

    /// Starts work on a read.
    void open(std::span<const std::uint8_t> read) {
        unseen_ = read;
        missing_ = 0;
        in_place_ = false;
    }
    /// Ends it, and returns what the decoder has not asked for.
    std::span<const std::uint8_t> close() {
        if (size_ == 0) {
            front_ = kept_.data();
            missing_ = 1;
        } else if (front_ != kept_.data()) {
            move_to_front();
        }
        return unseen_;
    }
    /// Instead of both: one more byte is kept, and so many more decide something.
    void keep_one(std::uint8_t byte, std::size_t missing) {
        kept_[size_] = byte;
        ++size_;
        missing_ = missing;
    }
    /// Instead of both: all that is kept is judged.
    void pass_kept() {
        first_position_ += size_;
        size_ = 0;
        missing_ = 1;
    }
    const std::uint8_t* kept() const { return kept_.data(); }
    // Instead of both, for a decoder that knows what comes: a look at `count` bytes at once, where
    // they stand if none are kept. Only while none is damaged.

    /// The byte that stands at this place among those that are kept and read.
    std::uint8_t peek(std::size_t position, std::span<const std::uint8_t> read) const {
        return position < size_ ? kept_[position] : read[position - size_];
    }
    /// Whether there are `count` bytes, no more than that of them kept; if not, keeps those of the
    /// read.
    bool reaches(std::size_t count, std::span<const std::uint8_t>& read) {
        if (size_ + read.size() >= count) {
            return true;
        }
        missing_ = count - size_;
        keep_all(read);
        read = {};
        return false;
    }
    /// The `count` bytes that there are; keeps those of the read too if it has not all of them.
    const std::uint8_t* whole(std::size_t count, std::span<const std::uint8_t>& read) {
        if (size_ == 0) {
            return read.data();
        }
        if (size_ < count) {
            const std::size_t more = count - size_;
            keep_all(read.first(more));
            read = read.subspan(more);
        }
        return kept_.data();
    }
    /// They are judged: none was kept.
    void pass(std::size_t count) { first_position_ += count; }
    /// They are judged.
    void pass(std::size_t count, std::span<const std::uint8_t>& read) {
        first_position_ += count;
        if (size_ == 0) {
            read = read.subspan(count);
        } else {
            size_ -= count;
            if (size_ != 0) {
                std::copy(kept_.data() + count, kept_.data() + count + size_, kept_.data());
            }
            missing_ = size_ == 0 ? 1 : 0;
        }
    }

    bool any_damaged() const { return damaged_.any(); }

    /// Makes at least `count` bytes visible. False if the read ends before; then all are.
    bool see(std::size_t count) {
        if (count <= size_) {
            return true;
        }
        if (size_ == 0) {
            front_ = unseen_.data();
            in_place_ = true;
        }
        const bool enough = count - size_ <= unseen_.size();
        const std::size_t more = enough ? count - size_ : unseen_.size();
        if (in_place_) {
            size_ += more;
        } else {
            append(unseen_.first(more));
        }
        unseen_ = unseen_.subspan(more);
        missing_ = enough ? 0 : count - size_;
        return enough;
    }
    void drop(std::size_t count) {
        front_ += count;
        size_ -= count;
        first_position_ += count;
        if (damaged_.any()) {
            damaged_ >>= count;
        }
    }

    /// The visible bytes.
    std::size_t size() const { return size_; }
    std::uint8_t operator[](std::size_t position) const { return front_[position]; }
    std::span<const std::uint8_t> view(std::size_t start, std::size_t count) const {
        return {front_ + start, count};
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
    /// Position in the stream of the first of them.
    std::uint64_t first_position() const { return first_position_; }

  private:
    /// Not inline: single bytes, which come most often, need no registers for this.
    [[gnu::noinline]] void keep_all(std::span<const std::uint8_t> bytes) {
        std::copy(bytes.begin(), bytes.end(), kept_.data() + size_);
        size_ += bytes.size();
        missing_ -= std::min(missing_, bytes.size());
    }
    void move_to_front() {
        std::copy(front_, front_ + size_, kept_.data());
        front_ = kept_.data();
    }
    void append(std::span<const std::uint8_t> bytes) {
        const auto begin = static_cast<std::size_t>(front_ - kept_.data());
        if (begin + size_ + bytes.size() > kept_.size()) {
            move_to_front();
        }
        std::uint8_t* const end = kept_.data() + (front_ - kept_.data()) + size_;
        if (bytes.size() == 1) {
            *end = bytes.front();
        } else {
            std::copy(bytes.begin(), bytes.end(), end);
        }
        size_ += bytes.size();
    }

    std::array<std::uint8_t, 2 * kCapacity> kept_{};
    const std::uint8_t* front_ = kept_.data();
    std::size_t size_ = 0;
    std::uint64_t first_position_ = 0;
    std::span<const std::uint8_t> unseen_;
    /// So many more bytes decide something; 0 if those that are kept do.
    std::size_t missing_ = 1;
    /// The visible bytes stand in the read, and not in `kept_`.
    bool in_place_ = false;
    std::bitset<kCapacity> damaged_;
};

}  // namespace tribus
