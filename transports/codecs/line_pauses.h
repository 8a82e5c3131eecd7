#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "core/time.h"

namespace tribus {

/// Tells from the instants of reads where a line paused between two bytes. The instant of a read is
/// that of its last byte; what it brought was on the wire for as long as so many bytes take. What
/// is left since the read before is a pause if it is longer than the port may hold bytes back:
/// 1 ms, or what frames show that go on behind such a gap, as adapters tear them that deliver in
/// lumps (FTDI each 16 ms, docs/protocols/sbus.md, "Serial port: latency"). Pure; thread-bound; no
/// heap.
class LinePauses {
  public:
    /// `byte_time`: of one byte on the wire; zero where it is not known, then times say nothing.
    explicit LinePauses(Duration byte_time) : byte_time_(byte_time) {}

    /// `count` bytes were read at `now`. Whether the line paused before the first of them.
    /// `waiting`: so many of those before wait for more, which a pause cuts off.
    bool before(std::size_t count, Instant now, std::size_t waiting) {
        const Instant latest = std::exchange(latest_, now);
        const std::uint64_t position = std::exchange(bytes_, bytes_ + count);
        if (latest == kNever || count == 0 || byte_time_ == Duration::zero()) {
            return false;
        }
        const Duration pause = now - latest - static_cast<Duration::rep>(count) * byte_time_;
        return pause > kPromptPort && judge(pause, position, waiting);
    }
    /// A frame came: its bytes from `first` on, counted over all reads.
    void frame_came(std::uint64_t first, std::size_t length) {
        frame_length_ = length;
        holds_back_ -= holds_back_ / kForgetting;
        if (within_position_ > first && within_position_ < first + length) {
            holds_back_ = std::max(holds_back_, within_);
        }
    }
    /// The time since the latest read tells nothing: nobody could read, or the line was away.
    void forget() { latest_ = kNever; }

  private:
    bool judge(Duration pause, std::uint64_t position, std::size_t waiting);
    bool went_on(std::uint64_t position, std::size_t waiting);

    /// As promptly as a UART delivers what it has, with the jitter of who reads.
    static constexpr Duration kPromptPort = std::chrono::milliseconds(1);
    /// No port holds bytes back for longer.
    static constexpr Duration kSlowestPort = std::chrono::milliseconds(40);
    /// One of so many parts with each frame.
    static constexpr int kForgetting = 256;
    static constexpr int kCutsToBelieve = 2;

    Duration byte_time_;
    Instant latest_ = kNever;
    /// Of all reads.
    std::uint64_t bytes_ = 0;
    /// The longest that frames have shown.
    Duration holds_back_{};
    std::size_t frame_length_ = 0;
    /// The latest gap that was taken for none, and the byte behind it.
    Duration within_{};
    std::uint64_t within_position_ = 0;
    /// The latest pause that cut bytes off, how many, and the byte behind it.
    Duration cut_{};
    std::size_t cut_off_ = 0;
    std::uint64_t cut_position_ = 0;
    int wrong_cuts_ = 0;
};

}  // namespace tribus
