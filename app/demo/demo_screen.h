#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "app/cli/screen_parts.h"
#include "core/channel_frame.h"
#include "core/time.h"

/// The screen of the demo. Pure.
namespace tribus {

struct DemoFigures {
    Duration elapsed{};
    std::string input_device;
    std::string output_device;
    ChannelFrame before;  ///< as the receiver sends it
    ChannelFrame after;   ///< as the servos read it
    bool link_up = true;
    double input_rate_hz = 0;
    double output_rate_hz = 0;
    std::uint64_t frames_in = 0;
    std::uint64_t frames_out = 0;
    std::uint64_t lost = 0;
    Duration latency_p50{};
    Duration latency_p99{};
    std::string latest_drop;  ///< a sentence; empty before the first
};

/// The whole screen, at most `rows` lines of at most `columns` characters. Leaves out the least
/// important lines if there is no room. Each line ends with "erase to end of line".
std::string draw_demo(const DemoFigures& figures, const ScreenStyle& style);

/// One line, for use without a terminal.
std::string demo_line(const DemoFigures& figures);

/// "good", "frame lost" or "failsafe".
std::string state_word(const ChannelFrame& frame);

}  // namespace tribus
