#pragma once

#include <cstddef>
#include <cstdint>

#include "core/time.h"

namespace tribus {

/// Spares the wakes of a port that delivers a frame byte by byte: after a frame's first byte it
/// tells how long nothing of interest can come. Only for such ports, and only while every frame is
/// as long as the one before and begins after a pause, so that its end is known. Pure;
/// thread-bound.
class ReadPacer {
  public:
    /// `byte_time`: of one byte on the wire; zero where there is no wire, then it never asks to
    /// wait.
    explicit ReadPacer(Duration byte_time) : byte_time_(byte_time) {}

    /// A read brought `bytes`, and a frame with them or not. Returns the instant at which to read
    /// next; `now` or before: as soon as something is there.
    Instant delivered(std::size_t bytes, bool frame_came, Instant now);

  private:
    void frame_ended();
    bool in_pieces() const { return frames_in_pieces_ >= kFramesToBelieve; }

    /// So many deliveries a frame are worth two more system calls.
    static constexpr int kManyDeliveries = 8;
    static constexpr int kFramesToBelieve = 8;
    /// A pause between frames is longer than the jitter between bytes.
    static constexpr int kPauseBytes = 5;
    /// Awake again so many bytes before the end.
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
