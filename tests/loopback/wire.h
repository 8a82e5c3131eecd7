#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "tests/support/far_end.h"

/// The two wire formats, written for the tests and independent of the program's codecs
/// (docs/protocols/ibus.md, "Servo frame" and "Channels 15 to 18", and docs/protocols/sbus.md,
/// "Frame" and "Scales").
namespace tribus::test {

using Clock = std::chrono::steady_clock;

/// 14 or 18 whole microseconds, channel 1 first.
using Sticks = std::vector<int>;

/// Returns channels at 1500 us, with another first channel by which the frame is recognised.
Sticks sticks_with_first(int first_us, std::size_t channels = 18);

Bytes ibus_bytes(const Sticks& sticks);

struct SbusSight {
    std::array<int, 16> raw{};
    bool channel_17 = false;
    bool channel_18 = false;
    bool frame_lost = false;
    bool failsafe = false;
    Clock::time_point seen{};

    bool good() const { return !frame_lost && !failsafe; }
};

Bytes sbus_bytes(const SbusSight& sight);

/// Raw value in Betaflight's scale, the default: 5/8 us a step, 880 us at 0; rounded and limited.
int sbus_raw(int us);
SbusSight sbus_sight_of(const Sticks& sticks);
/// Returns whether the channels are the same, whatever the flags.
bool same_channels(const SbusSight& a, const SbusSight& b);

/// Reads SBUS frames at the far end of a wire.
class ServoBank {
  public:
    explicit ServoBank(FarEnd& wire) : wire_(wire) {}
    /// The frames that have arrived since the last call.
    std::vector<SbusSight> listen();
    /// Number of bytes that belonged to no frame.
    std::size_t strays() const { return strays_; }

  private:
    FarEnd& wire_;
    Bytes pending_;
    std::size_t strays_ = 0;
};

/// Reads i.Bus frames at the far end of a wire.
class IbusReader {
  public:
    explicit IbusReader(FarEnd& wire) : wire_(wire) {}
    std::vector<Sticks> listen();
    std::size_t strays() const { return strays_; }

  private:
    FarEnd& wire_;
    Bytes pending_;
    std::size_t strays_ = 0;
};

}  // namespace tribus::test
