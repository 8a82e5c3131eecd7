#include "transports/codecs/joystick/joystick.h"

#include <algorithm>

namespace tribus {
namespace {

/// 988 us.
constexpr int kAxisZeroEighths = 8 * 988;
/// Two steps a microsecond.
constexpr int kEighthsAStep = 4;

std::uint16_t axis_value(Pulse pulse) {
    const int steps = (pulse.eighths() - kAxisZeroEighths + kEighthsAStep / 2) >> 2;
    return static_cast<std::uint16_t>(std::clamp<int>(steps, 0, kJoystickMost));
}

}  // namespace

std::uint32_t JoystickEncoder::needed_channels(const ChannelFrame& /*frame*/) const {
    std::uint32_t needed = 0;
    for (const auto& channel : settings_.axes) {
        needed |= channel ? 1U << *channel : 0U;
    }
    for (const JoystickButton& button : settings_.buttons) {
        needed |= 1U << button.channel;
    }
    return needed;
}

std::size_t JoystickEncoder::write(const ChannelFrame& frame,
                                   std::span<std::uint8_t, kLongestSerialFrame> wire,
                                   Instant /*now*/) {
    const auto report = wire.first<kJoystickReportBytes>();
    std::ranges::fill(report, std::uint8_t{0});
    for (const JoystickButton& button : settings_.buttons) {
        const bool pressed = button.is_pressed(frame.channel_or(button.channel, kSwitchOffPulse));
        report[button.button / 8] = static_cast<std::uint8_t>(
            report[button.button / 8] | (pressed ? 1U : 0U) << button.button % 8);
    }
    for (std::size_t axis = 0; axis < settings_.axes.size(); ++axis) {
        const auto& channel = settings_.axes[axis];
        set_joystick_axis(
            report, axis,
            channel ? axis_value(frame.channel_or(*channel, kCentrePulse)) : kJoystickCentre);
    }
    return report.size();
}

std::size_t JoystickEncoder::write_silence(std::span<std::uint8_t, kLongestSerialFrame> wire,
                                           Instant /*now*/) {
    const auto report = wire.first<kJoystickReportBytes>();
    std::ranges::fill(report, std::uint8_t{0});
    for (std::size_t axis = 0; axis < settings_.axes.size(); ++axis) {
        const auto& channel = settings_.axes[axis];
        const bool low = channel && channel == settings_.throttle;
        set_joystick_axis(report, axis, low ? std::uint16_t{0} : kJoystickCentre);
    }
    return report.size();
}

}  // namespace tribus
