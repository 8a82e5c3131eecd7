#pragma once

#include <cstddef>
#include <vector>

#include "tests/captures/recordings.h"
#include "tests/loopback/wire.h"
#include "tests/support/far_end.h"
#include "transports/recordings/recording.h"

namespace tribus::test {

/// Returns the sticks in the recording of a FlySky AFHDS3 receiver, or in its twin: 18 channels
/// every 4 ms for 5 s (tests/captures/receivers.cpp).
std::vector<Sticks> recorded_sticks(Capture capture);

/// Replays that receiver with the recorded times.
class RecordedReceiver {
  public:
    RecordedReceiver(FarEnd& wire, Capture capture);

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
