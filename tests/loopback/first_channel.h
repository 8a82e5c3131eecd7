#pragma once

#include <gtest/gtest.h>

#include "tests/loopback/loopback.h"

namespace tribus::test {

/// A receiver sends 1100 us on channel 1. The servos' value shows which configuration runs.
class FirstChannel : public Loopback {
  protected:
    /// Sends until the servos get a good frame whose first channel is `first_us`.
    void expect_first_channel(int first_us) {
        EXPECT_TRUE(eventually([&] {
            repeater_.send_if_due();
            const auto seen = servos_.listen();
            return !seen.empty() && seen.back().good() && seen.back().raw[0] == sbus_raw(first_us);
        })) << "channel 1 was never "
            << first_us;
    }

    FarEnd& receiver_ = device("receiver");
    ServoBank servos_{device("servos")};
    Repeater repeater_{receiver_, ibus_bytes(sticks_with_first(1100))};
};

}  // namespace tribus::test
