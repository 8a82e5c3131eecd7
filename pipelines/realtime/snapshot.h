#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace tribus {

/// A value that one thread publishes and others read, without a lock. The writer never waits; a
/// reader tries again if it was overtaken. Before the first `publish` it is a default value.
/// `publish`: thread-bound to the writer. `read`: thread-safe.
template <class Value>
class Snapshot {
    static_assert(std::is_trivially_copyable_v<Value>);

  public:
    Snapshot() { publish(Value{}); }

    void publish(const Value& value) {
        Words words{};
        std::memcpy(words.data(), &value, sizeof value);
        const std::uint32_t version = version_.load(std::memory_order_relaxed);
        version_.store(version + 1, std::memory_order_relaxed);
        std::atomic_thread_fence(std::memory_order_release);
        for (std::size_t i = 0; i < words.size(); ++i) {
            words_[i].store(words[i], std::memory_order_relaxed);
        }
        version_.store(version + 2, std::memory_order_release);
    }

    Value read() const {
        Words words{};
        std::uint32_t before = 0;
        std::uint32_t after = 0;
        do {
            before = version_.load(std::memory_order_acquire);
            for (std::size_t i = 0; i < words.size(); ++i) {
                words[i] = words_[i].load(std::memory_order_relaxed);
            }
            std::atomic_thread_fence(std::memory_order_acquire);
            after = version_.load(std::memory_order_relaxed);
        } while (before != after || before % 2 != 0);
        Value value;
        std::memcpy(static_cast<void*>(&value), words.data(), sizeof value);
        return value;
    }

  private:
    static constexpr std::size_t kWords = (sizeof(Value) + 7) / 8;
    using Words = std::array<std::uint64_t, kWords>;
    std::atomic<std::uint32_t> version_{0};
    std::array<std::atomic<std::uint64_t>, kWords> words_{};
};

}  // namespace tribus
