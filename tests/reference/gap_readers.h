#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>

#include "core/time.h"

/// Two readers that find SBUS frames by gaps alone, as flight controllers do
/// (docs/protocols/sbus.md, "Synchronisation", from their sources).
namespace tribus::reference {

/// Collects a frame of 25 bytes that starts with a header.
class GapSbusReader {
  public:
    using Frame = std::array<std::uint8_t, 25>;

  protected:
    const Frame* fill(std::uint8_t byte) {
        constexpr std::uint8_t kHeader = 0x0F;
        if (count_ == 0 && byte != kHeader) {
            return nullptr;
        }
        frame_[count_] = byte;
        ++count_;
        return count_ == frame_.size() ? &frame_ : nullptr;
    }
    Duration gap_before(Duration at) {
        const Duration gap = at - latest_;
        latest_ = at;
        return gap;
    }

    Frame frame_{};
    std::size_t count_ = 0;
    /// A time long before the first byte.
    Duration latest_ = std::chrono::seconds(-1);
};

/// betaflight src/main/rx/sbus.c: a frame begins after more than 600 us without a byte. Bytes after
/// a whole frame are ignored until the next such gap. Flags and footer are not checked.
class BetaflightSbusReader : public GapSbusReader {
  public:
    const Frame* take(std::uint8_t byte, Duration at) {
        if (gap_before(at) > std::chrono::microseconds(600)) {
            count_ = 0;
        }
        return count_ < frame_.size() ? fill(byte) : nullptr;
    }
};

/// ArduPilot libraries/AP_RCProtocol/AP_RCProtocol_SBUS.cpp: a frame begins with a header after
/// 4000 us without a byte. Flags and footer are not checked.
class ArduPilotSbusReader : public GapSbusReader {
  public:
    const Frame* take(std::uint8_t byte, Duration at) {
        const bool gap = gap_before(at) >= std::chrono::microseconds(4000);
        if (gap) {
            count_ = 0;
        }
        if (count_ == 0 && !gap) {
            return nullptr;
        }
        const Frame* const whole = fill(byte);
        if (whole != nullptr) {
            count_ = 0;
        }
        return whole;
    }
};

}  // namespace tribus::reference
