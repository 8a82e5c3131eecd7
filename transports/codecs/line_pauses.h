#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "core/time.h"

namespace tribus {

/// Finds pauses between the bytes of a line from the instants of reads. The instant of a read is
/// that of its last byte, and its bytes were on the wire for their transmission time. The time left
/// since the previous read is a pause if it is longer than the port may hold bytes back: 1 ms, or
/// more for adapters that deliver in lumps (FTDI every 16 ms, docs/protocols/sbus.md, "Serial port:
/// latency"), which shows in frames that continue after a gap. Pure; thread-bound; no heap.
class LinePauses {
  public:
    /// `byte_time`: duration of one byte on the wire. Zero if unknown; then there are no pauses.
    explicit LinePauses(Duration byte_time) : byte_time_(byte_time) {}

    /// `count` bytes were read at `now`. Returns whether the line paused before the first of them.
    /// `waiting`: number of earlier bytes that wait for more; a pause cuts them off.
    bool before(std::size_t count, Instant now, std::size_t waiting) {
        const Instant latest = std::exchange(latest_, now);
        const std::uint64_t position = std::exchange(bytes_, bytes_ + count);
        if (latest == kNever || count == 0 || byte_time_ == Duration::zero()) {
            return false;
        }
        const Duration pause = now - latest - static_cast<Duration::rep>(count) * byte_time_;
        return pause > kPromptPort && judge(pause, position, waiting);
    }
    /// A frame came, with its first byte at position `first` of all bytes read.
    void frame_came(std::uint64_t first, std::size_t length) {
        frame_length_ = length;
        holds_back_ -= holds_back_ / kHoldBackDecay;
        if (within_position_ > first && within_position_ < first + length) {
            holds_back_ = std::max(holds_back_, within_);
        }
    }
    /// Ignores the time since the latest read: nobody could read, or the line was unplugged.
    void forget() { latest_ = kNever; }

  private:
    bool judge(Duration pause, std::uint64_t position, std::size_t waiting);
    bool was_wrong_cut(std::uint64_t position, std::size_t waiting);

    /// Delay of a UART that delivers at once, with the jitter of the reader.
    static constexpr Duration kPromptPort = std::chrono::milliseconds(1);
    /// Longest time for which any port holds bytes back.
    static constexpr Duration kSlowestPort = std::chrono::milliseconds(40);
    /// Share by which the hold-back time shrinks with each frame.
    static constexpr int kHoldBackDecay = 256;
    static constexpr int kWrongCutsNeeded = 2;

    Duration byte_time_;
    Instant latest_ = kNever;
    /// Number of all bytes read.
    std::uint64_t bytes_ = 0;
    /// Longest time for which the port held bytes back, as seen in frames.
    Duration holds_back_{};
    std::size_t frame_length_ = 0;
    /// The latest gap that was no pause, and the position after it.
    Duration within_{};
    std::uint64_t within_position_ = 0;
    /// The latest pause, how many bytes it cut off, and the position after it.
    Duration cut_{};
    std::size_t cut_off_ = 0;
    std::uint64_t cut_position_ = 0;
    int wrong_cuts_ = 0;
};

}  // namespace tribus
