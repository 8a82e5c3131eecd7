#pragma once

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

namespace tribus {

/// Marks of the buffered bytes that had a parity or framing error.
class DamageMarks {
  public:
    static constexpr std::size_t kWordBits = 64;

    bool any() const { return (words_[0] | words_[1]) != 0; }
    /// Marks of the 64 bytes from `position` on, the first in the lowest bit.
    std::uint64_t from(std::size_t position) const {
        assert(position <= 4 * kWordBits);
        const std::uint64_t upper = words_[1];
        if (position == 0) {
            return words_[0];
        }
        if (position >= kWordBits) {
            return position >= 2 * kWordBits ? 0 : upper >> (position - kWordBits);
        }
        return words_[0] >> position | upper << (kWordBits - position);
    }
    void set(std::size_t position) {
        assert(position < words_.size() * kWordBits);
        words_[position / kWordBits] |= std::uint64_t{1} << (position % kWordBits);
    }
    void drop(std::size_t count) {
        if (any()) {
            words_ = {from(count), from(count + kWordBits)};
        }
    }
    void clear() { words_ = {}; }

  private:
    std::array<std::uint64_t, 2> words_{};
};

/// The bytes that a decoder has not decided yet, each with a mark if it was damaged, and their
/// position in the whole stream.
///
/// While a decoder works on a read, the bytes stay where the read put them; only those that outlast
/// the read are copied. A decoder sees only the bytes that it asked for, so its result does not
/// depend on how the stream is cut into reads. Thread-bound; no heap.
class LineBuffer {
  public:
    /// Upper limit of the bytes that a decoder asks for at once, and of those that it leaves.
    static constexpr std::size_t kCapacity = 128;

    /// Between two reads: if the decoder needs more bytes than it has with these, keeps all of them
    /// and returns true.
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
    /// Between two reads: a damaged byte stood here. `decides`: it decides something by itself;
    /// else only once the bytes are there that the decoder waits for.
    void append_damaged(bool decides = true) {
        assert(size_ < kCapacity);
        kept_[size_] = 0;
        damaged_.set(size_);
        ++size_;
        missing_ = decides || missing_ == 0 ? 0 : missing_ - 1;
    }

    /// Starts work on a read.
    void open(std::span<const std::uint8_t> read) {
        unseen_ = read;
        missing_ = 0;
        in_place_ = false;
    }
    /// Ends work on a read. Returns the bytes that the decoder has not asked for.
    std::span<const std::uint8_t> close() {
        if (size_ == 0) {
            front_ = kept_.data();
            missing_ = 1;
        } else if (front_ != kept_.data()) {
            move_to_front();
        }
        return unseen_;
    }
    /// Instead of open and close: keeps one more byte. `missing` more bytes are needed to decide
    /// something.
    void keep_one(std::uint8_t byte, std::size_t missing) {
        assert(size_ < kCapacity);
        kept_[size_] = byte;
        ++size_;
        missing_ = missing;
    }
    /// Instead of open and close: everything in the buffer is decided.
    void pass_kept() {
        first_position_ += size_;
        size_ = 0;
        missing_ = 1;
    }
    const std::uint8_t* kept() const { return kept_.data(); }
    // Instead of open and close, for a decoder that knows what to expect: access to `count` bytes
    // at once, in place if none are buffered. Only while no byte is damaged.

    /// The byte at this position of the buffered bytes and the read.
    std::uint8_t peek(std::size_t position, std::span<const std::uint8_t> read) const {
        return position < size_ ? kept_[position] : read[position - size_];
    }
    /// Whether buffer and read have `count` bytes; the buffer holds at most that many. If not,
    /// keeps the bytes of the read.
    bool reaches(std::size_t count, std::span<const std::uint8_t>& read) {
        if (size_ + read.size() >= count) {
            return true;
        }
        missing_ = count - size_;
        keep_all(read);
        read = {};
        return false;
    }
    /// The first `count` bytes, which must be there. Copies bytes of the read if the buffer has
    /// fewer.
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
    /// The first `count` bytes of the read are decided. The buffer is empty.
    void pass(std::size_t count) { first_position_ += count; }
    /// The first `count` bytes are decided: the buffered ones, then those of the read.
    void pass(std::size_t count, std::span<const std::uint8_t>& read) {
        first_position_ += count;
        if (count >= size_) {
            read = read.subspan(count - size_);
            size_ = 0;
            missing_ = 1;
            damaged_.clear();
        } else if (count != 0) {
            size_ -= count;
            to_front(kept_.data() + count, size_);
            missing_ = 0;
            damaged_.drop(count);
        }
    }
    /// The first `judged` bytes of buffer and read are decided. Keeps `rest`, all bytes after them,
    /// until there are `count`.
    void hold(std::span<const std::uint8_t> rest, std::size_t judged, std::size_t count) {
        if (rest.data() == kept_.data() + judged) {
            to_front(rest.data(), rest.size());
            damaged_.drop(judged);
        } else {
            std::copy(rest.begin(), rest.end(), kept_.data());
        }
        first_position_ += judged;
        size_ = rest.size();
        missing_ = count - size_;
    }
    /// The buffered bytes followed by the first `most` bytes of the read. All buffered bytes can
    /// then be decided, and stay in the buffer.
    std::span<const std::uint8_t> join(std::span<const std::uint8_t> read, std::size_t most) {
        const std::size_t more = std::min(most, read.size());
        assert(size_ + more <= kept_.size());
        if (more == 1) {
            kept_[size_] = read.front();
        } else if (more != 0) {
            std::copy(read.begin(), read.begin() + static_cast<std::ptrdiff_t>(more),
                      kept_.data() + size_);
        }
        return {kept_.data(), size_ + more};
    }

    bool any_damaged() const { return damaged_.any(); }

    /// Makes at least `count` bytes visible. If the read has too few, makes all visible and returns
    /// false.
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
        assert(count <= size_);
        front_ += count;
        size_ -= count;
        first_position_ += count;
        damaged_.drop(count);
    }

    /// Number of visible bytes.
    std::size_t size() const { return size_; }
    std::uint8_t operator[](std::size_t position) const {
        assert(position < size_);
        return front_[position];
    }
    std::span<const std::uint8_t> view(std::size_t start, std::size_t count) const {
        assert(start + count <= size_);
        return {front_ + start, count};
    }
    bool damaged(std::size_t position) const { return (damaged_.from(position) & 1U) != 0; }
    /// Whether one of `count` bytes, at most 63, is damaged.
    bool damaged(std::size_t start, std::size_t count) const {
        assert(count < DamageMarks::kWordBits);
        return (damaged_.from(start) & ((std::uint64_t{1} << count) - 1)) != 0;
    }
    const DamageMarks& damage() const { return damaged_; }
    /// Position in the stream of the first visible byte.
    std::uint64_t first_position() const { return first_position_; }

  private:
    void keep_all(std::span<const std::uint8_t> bytes) {
        assert(size_ + bytes.size() <= kept_.size());
        std::copy(bytes.begin(), bytes.end(), kept_.data() + size_);
        size_ += bytes.size();
        missing_ -= std::min(missing_, bytes.size());
    }
    /// Moves buffered bytes to the front; a few of them as a piece of fixed size, which needs no
    /// loop.
    void to_front(const std::uint8_t* begin, std::size_t count) {
        constexpr std::size_t kPiece = 64;
        static_assert(2 * kPiece <= kCapacity);
        if (begin == kept_.data()) {
            return;
        }
        if (count <= kPiece && begin + kPiece <= kept_.data() + kept_.size()) {
            std::array<std::uint8_t, kPiece> piece;
            std::memcpy(piece.data(), begin, kPiece);
            std::memcpy(kept_.data(), piece.data(), kPiece);
        } else {
            std::copy(begin, begin + count, kept_.data());
        }
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
    /// Number of further bytes that decide something; 0 if the buffered ones do.
    std::size_t missing_ = 1;
    /// The visible bytes are in the read, not in `kept_`.
    bool in_place_ = false;
    DamageMarks damaged_;
    static_assert(kCapacity <= 2 * DamageMarks::kWordBits);
};

}  // namespace tribus
