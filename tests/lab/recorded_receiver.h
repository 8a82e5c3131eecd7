#pragma once

#include <cstddef>
#include <vector>

#include "tests/loopback/wire.h"
#include "tests/support/far_end.h"
#include "transports/recordings/recording.h"

namespace tribus::test {

/// Returns the sticks in the recording of a FlySky AFHDS3 receiver, 18 channels every 4 ms for 5 s
/// (origin in the README of the captures). Returns none if the captures are missing.
std::vector<Sticks> recorded_sticks();

/// Replays that receiver with the recorded times.
class RecordedReceiver {
  public:
    /// The recordings are in the folder of the captures.
    explicit RecordedReceiver(FarEnd& wire);

    /// Starts with the first burst.
    void start();
    void send_due();
    bool ended() const { return next_ >= bursts_.size(); }
    /// Time just before the latest burst was sent.
    Clock::time_point latest() const { return latest_; }

  private:
    FarEnd& wire_;
    std::vector<Burst> bursts_;
    std::size_t next_ = 0;
    Clock::time_point started_{};
    Clock::time_point latest_{};
};

}  // namespace tribus::test
