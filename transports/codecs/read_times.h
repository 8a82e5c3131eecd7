#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "core/time.h"
#include "transports/codecs/line_buffer.h"

namespace tribus {

/// Times at which the latest bytes of a stream were read: as many as a decoder can hold back while
/// a frame waits for its proof. Thread-bound; no heap.
class ReadTimes {
  public:
    /// The bytes before position `end` that were not there before were read at `now`. Does nothing
    /// if there are none.
    void add(std::uint64_t end, Instant now) {
        if (end != end_) {
            latest_ = (latest_ + 1) % kReads;
            brought_[latest_] = static_cast<std::uint16_t>(std::min(end - end_, kMostThatMatter));
            at_[latest_] = now;
            end_ = end;
        }
    }
    /// When the byte at `position` was read. It must be one of the latest `LineBuffer::kCapacity`
    /// bytes.
    Instant of(std::uint64_t position) const {
        std::size_t read = latest_;
        std::uint64_t begin = end_ - brought_[read];
        for (std::size_t i = 1; i < kReads && begin > position; ++i) {
            read = (read + kReads - 1) % kReads;
            begin -= brought_[read];
        }
        return at_[read];
    }

  private:
    /// Each read brings at least one byte, so no more reads matter.
    static constexpr std::size_t kReads = LineBuffer::kCapacity;
    /// Of a longer read, only the latest bytes are asked for.
    static constexpr std::uint64_t kMostThatMatter = 0xFFFF;
    static_assert(kMostThatMatter >= LineBuffer::kCapacity);
    // The number of bytes that each read brought takes less memory than its position.
    std::array<std::uint16_t, kReads> brought_{};
    std::array<Instant, kReads> at_{};
    std::uint64_t end_ = 0;
    std::size_t latest_ = 0;
};

}  // namespace tribus
