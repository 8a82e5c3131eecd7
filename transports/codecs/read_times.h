#pragma once

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
        if (end != reads_[latest_].end) {
            latest_ = (latest_ + 1) % reads_.size();
            reads_[latest_] = {end, now};
        }
    }
    /// When the byte at `position` was read. It must be one of the latest `LineBuffer::kCapacity`
    /// bytes.
    Instant of(std::uint64_t position) const {
        std::size_t read = latest_;
        for (std::size_t i = 1; i < reads_.size(); ++i) {
            const std::size_t before = (read + reads_.size() - 1) % reads_.size();
            if (reads_[before].end <= position) {
                break;
            }
            read = before;
        }
        return reads_[read].at;
    }

  private:
    struct Read {
        std::uint64_t end = 0;
        Instant at{};
    };
    /// Each read brings at least one byte, so no more reads matter.
    std::array<Read, LineBuffer::kCapacity> reads_{};
    std::size_t latest_ = 0;
};

}  // namespace tribus
