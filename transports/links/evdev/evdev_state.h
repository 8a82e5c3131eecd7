#pragma once

#include <linux/input.h>

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/gamepad_report.h"

namespace tribus {

/// What the kernel's events say of a gamepad: where its axes are, which buttons are pressed. Pure.
/// No heap.
class EvdevState {
  public:
    /// Adds an axis. Axes beyond gamepad_report::kMostAxes are left out.
    void add_axis(std::uint16_t code, const input_absinfo& range);

    enum class Outcome : std::uint8_t {
        none,
        complete,  ///< the state at this instant is known
        dropped,   ///< the kernel had no room and dropped events: read the whole state anew
    };
    Outcome take(const input_event& event);

    /// After `dropped`, or at the start: the whole state.
    std::span<const std::uint16_t> axis_codes() const { return {codes_.data(), axes_}; }
    void set_axis(std::uint16_t code, std::int32_t value);
    void set_button(std::uint16_t code, bool pressed);

    /// Writes a report, and returns its length. A button counts as pressed in the next report also
    /// if it was released meanwhile. `gone`: it is the last one.
    std::size_t write(std::span<std::uint8_t, gamepad_report::kMostBytes> report, bool gone);

  private:
    static constexpr std::size_t kFirstButton = BTN_MISC;

    /// From -kFullDeflection to kFullDeflection.
    static int scaled(const input_absinfo& range);

    std::size_t axes_ = 0;
    std::array<std::uint16_t, gamepad_report::kMostAxes> codes_{};
    std::array<input_absinfo, gamepad_report::kMostAxes> ranges_{};
    /// By code, from BTN_MISC on.
    std::bitset<KEY_CNT - kFirstButton> pressed_;
    std::bitset<KEY_CNT - kFirstButton> pressed_since_report_;
    bool changed_ = true;
    bool dropping_ = false;
};

}  // namespace tribus
