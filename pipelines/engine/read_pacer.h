#pragma once

#include <cstddef>
#include <cstdint>

#include "core/time.h"

namespace tribus {

/// Saves wake-ups on a port that delivers a frame byte by byte: after the first byte of a frame it
/// tells how long not to read. Applies only while every frame is as long as the one before and
/// starts after a pause, so that its end is known. Pure. Thread-bound.
class ReadPacer {
  public:
    /// `byte_time`: duration of one byte on the wire. Zero if there is no wire; then it never
    /// waits.
    explicit ReadPacer(Duration byte_time) : byte_time_(byte_time) {}

    /// A read delivered `bytes`, with or without the end of a frame. Returns when to read next;
    /// `now` or earlier means: as soon as bytes arrive.
    Instant delivered(std::size_t bytes, bool frame_came, Instant now);

  private:
    void frame_ended();
    bool in_pieces() const { return frames_in_pieces_ >= kFramesToConfirm; }

    /// Deliveries per frame from which pacing saves more than its two system calls cost.
    static constexpr int kManyDeliveries = 8;
    static constexpr int kFramesToConfirm = 8;
    /// A pause between frames is longer than the jitter between bytes.
    static constexpr int kPauseBytes = 5;
    /// Reading resumes this many bytes before the end of the frame.
    static constexpr std::size_t kEarlyBytes = 2;

    Duration byte_time_;
    Instant latest_{};
    std::size_t frame_length_ = 0;
    std::size_t bytes_ = 0;
    int deliveries_ = 0;
    bool paced_ = false;
    int frames_in_pieces_ = 0;
};

}  // namespace tribus
