#pragma once

#include <cstddef>
#include <vector>

#include "tests/loopback/wire.h"
#include "tests/support/far_end.h"
#include "transports/links/recording.h"

namespace tribus::test {

/// The sticks of the recording of a FlySky AFHDS3 receiver, 18 channels each 4 ms for 5 s (origin
/// in the README of the captures); none where the captures are missing.
std::vector<Sticks> recorded_sticks();

/// That receiver: sends what it was recorded to send, when it did.
class RecordedReceiver {
  public:
    /// `captures` has the recordings.
    explicit RecordedReceiver(FarEnd& wire);

    /// From the first burst on.
    void start();
    void send_due();
    bool ended() const { return next_ >= bursts_.size(); }
    /// Before the latest burst was handed over.
    Clock::time_point latest() const { return latest_; }

  private:
    FarEnd& wire_;
    std::vector<Burst> bursts_;
    std::size_t next_ = 0;
    Clock::time_point started_{};
    Clock::time_point latest_{};
};

}  // namespace tribus::test
