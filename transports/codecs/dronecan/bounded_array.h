#pragma once

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <string_view>

namespace tribus::dronecan {

/// Up to N items inside the object itself, without heap: a dynamic array of DSDL.
template <class T, std::size_t N>
class BoundedArray {
  public:
    using Item = T;

    constexpr BoundedArray() = default;
    /// At most N items.
    constexpr BoundedArray(std::initializer_list<T> items) {
        assert(items.size() <= N);
        std::copy(items.begin(), items.end(), items_.begin());
        size_ = items.size();
    }

    static constexpr std::size_t capacity() { return N; }
    constexpr std::size_t size() const { return size_; }
    constexpr bool empty() const { return size_ == 0; }
    constexpr bool full() const { return size_ == N; }

    /// `size` is at most N. New items are T{}.
    constexpr void resize(std::size_t size) {
        assert(size <= N);
        for (std::size_t at = size_; at < size; ++at) {
            items_[at] = T{};
        }
        size_ = size;
    }
    /// Must not be full().
    constexpr void push_back(const T& item) {
        assert(!full());
        items_[size_++] = item;
    }

    constexpr T& operator[](std::size_t at) { return items_[at]; }
    constexpr const T& operator[](std::size_t at) const { return items_[at]; }
    constexpr T* data() { return items_.data(); }
    constexpr const T* data() const { return items_.data(); }
    constexpr T* begin() { return items_.data(); }
    constexpr T* end() { return items_.data() + size_; }
    constexpr const T* begin() const { return items_.data(); }
    constexpr const T* end() const { return items_.data() + size_; }

    friend constexpr bool operator==(const BoundedArray& one, const BoundedArray& other) {
        return std::equal(one.begin(), one.end(), other.begin(), other.end());
    }

  private:
    std::array<T, N> items_{};
    std::size_t size_ = 0;
};

/// Text in DSDL: an array of bytes, mostly ASCII.
template <std::size_t N>
class BoundedText : public BoundedArray<std::uint8_t, N> {
  public:
    constexpr BoundedText() = default;
    /// Cuts a text that is too long.
    constexpr explicit BoundedText(std::string_view text) {
        for (const char letter : text.substr(0, N)) {
            this->push_back(static_cast<std::uint8_t>(letter));
        }
    }

    std::string_view view() const {
        return {reinterpret_cast<const char*>(this->data()), this->size()};
    }
};

}  // namespace tribus::dronecan
