#include "transports/codecs/gamepad/gamepad.h"

#include <algorithm>
#include <utility>

#include "core/gamepad_report.h"

namespace tribus {

using namespace gamepad_report;

namespace {

using GamepadReport = std::span<const std::uint8_t>;

/// A stick at rest is within a tenth of its way.
constexpr int kRest = kFullDeflection / 10;
/// Half of the way of an axis.
constexpr int kHalfWayEighths = 8 * 500;

std::size_t report_bytes(GamepadReport report) {
    return kHeaderBytes + kAxisBytes * report[kAxisCountAt] + kButtonBytes * report[kButtonCountAt];
}

std::optional<int> position_of(GamepadReport report, std::uint16_t code) {
    for (std::size_t axis = 0; axis < report[kAxisCountAt]; ++axis) {
        const std::size_t at = kHeaderBytes + kAxisBytes * axis;
        if (report[at] == code) {
            return static_cast<std::int16_t>(report[at + 1] | report[at + 2] << 8);
        }
    }
    return std::nullopt;
}

bool has_pressed(GamepadReport report, std::uint16_t code) {
    const std::size_t first = kHeaderBytes + kAxisBytes * report[kAxisCountAt];
    for (std::size_t button = 0; button < report[kButtonCountAt]; ++button) {
        const std::size_t at = first + kButtonBytes * button;
        if ((report[at] | report[at + 1] << 8) == code) {
            return true;
        }
    }
    return false;
}

Pulse pulse_at(int position) {
    const int way = position * kHalfWayEighths;
    const int half = (way >= 0 ? kFullDeflection : -kFullDeflection) / 2;
    return Pulse::from_eighths(kCentrePulse.eighths() + (way + half) / kFullDeflection);
}

}  // namespace

GamepadDecoder::GamepadDecoder(GamepadSettings settings)
    : settings_(std::move(settings)),
      toggled_(settings_.buttons.size()),
      pressed_(settings_.buttons.size()) {}

void GamepadDecoder::reset() {
    FramedDecoder::reset();
    trust_ = Trust::waits_for_rest;
    changed_at_.reset();
    toggled_.assign(toggled_.size(), false);
}

std::size_t GamepadDecoder::needed_bytes(std::span<const std::uint8_t> bytes) const {
    if (bytes[0] != kMagic) {
        return 0;
    }
    if (bytes.size() < kHeaderBytes) {
        return kHeaderBytes;
    }
    const bool possible = bytes[kAxisCountAt] <= kMostAxes && bytes[kButtonCountAt] <= kMostButtons;
    return possible ? report_bytes(bytes) : 0;
}

bool GamepadDecoder::check_holds(std::span<const std::uint8_t> frame) const {
    return (frame[kReportFlagsAt] & ~(kGone | kChanged)) == 0;
}

void GamepadDecoder::set_axes(std::span<const std::uint8_t> frame, ChannelFrame& channels) const {
    for (const GamepadAxis& axis : settings_.axes) {
        if (const auto position = position_of(frame, axis.code)) {
            channels.set(axis.channel, pulse_at(axis.reverse ? -*position : *position));
        }
    }
}

void GamepadDecoder::set_buttons(std::span<const std::uint8_t> frame, ChannelFrame& channels) {
    for (std::size_t i = 0; i < settings_.buttons.size(); ++i) {
        const GamepadButton& button = settings_.buttons[i];
        const bool pressed = has_pressed(frame, button.code);
        const bool came = pressed && !pressed_[i] && trust_ == Trust::full;
        toggled_[i] = toggled_[i] != came;
        pressed_[i] = pressed;
        const bool on = button.toggles ? toggled_[i] : pressed;
        channels.set(button.channel, on ? kSwitchOnPulse : kSwitchOffPulse);
    }
}

/// An axis that does not come back by itself, such as a trigger, may also rest at its end.
bool GamepadDecoder::is_at_rest(std::span<const std::uint8_t> frame) const {
    return std::ranges::all_of(settings_.axes, [frame](const GamepadAxis& axis) {
        const int position = position_of(frame, axis.code).value_or(0);
        return (position >= -kRest && position <= kRest) || position <= -kFullDeflection + kRest;
    });
}

void GamepadDecoder::judge_trust(std::span<const std::uint8_t> frame) {
    const std::size_t pressed = frame[kButtonCountAt];
    if (trust_ == Trust::waits_for_rest && is_at_rest(frame)) {
        trust_ = Trust::waits_for_press;
    } else if (trust_ == Trust::waits_for_press && pressed > pressed_before_) {
        trust_ = Trust::full;
    }
    pressed_before_ = pressed;
}

bool GamepadDecoder::is_active(bool changed, Instant received) {
    if (changed || !changed_at_) {
        changed_at_ = received;
    }
    return !settings_.activity_timeout || received - *changed_at_ < *settings_.activity_timeout;
}

bool GamepadDecoder::read(std::span<const std::uint8_t> frame, ChannelFrame& channels) {
    const bool gone = (frame[kReportFlagsAt] & kGone) != 0;
    judge_trust(frame);
    set_axes(frame, channels);
    set_buttons(frame, channels);
    const bool active = is_active((frame[kReportFlagsAt] & kChanged) != 0, channels.received);
    const bool held = !settings_.dead_man || has_pressed(frame, *settings_.dead_man);
    channels.failsafe = gone || trust_ != Trust::full || !active || !held;
    return true;
}

}  // namespace tribus
