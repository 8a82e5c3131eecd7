#include "transports/links/evdev/evdev_state.h"

#include <algorithm>

namespace tribus {

using namespace gamepad_report;

void EvdevState::add_axis(std::uint16_t code, const input_absinfo& range) {
    if (axes_ < codes_.size() && range.maximum > range.minimum) {
        codes_[axes_] = code;
        ranges_[axes_] = range;
        ++axes_;
    }
}

void EvdevState::set_axis(std::uint16_t code, std::int32_t value) {
    for (std::size_t axis = 0; axis < axes_; ++axis) {
        if (codes_[axis] == code) {
            changed_ = changed_ || ranges_[axis].value != value;
            ranges_[axis].value = value;
        }
    }
}

void EvdevState::set_button(std::uint16_t code, bool pressed) {
    if (code < kFirstButton || code >= KEY_CNT) {
        return;
    }
    const std::size_t index = code - kFirstButton;
    changed_ = changed_ || pressed_[index] != pressed;
    pressed_[index] = pressed;
    pressed_since_report_[index] = pressed_since_report_[index] || pressed;
}

EvdevState::Outcome EvdevState::take(const input_event& event) {
    if (event.type == EV_SYN && event.code == SYN_DROPPED) {
        dropping_ = true;
        return Outcome::none;
    }
    if (event.type == EV_SYN && event.code == SYN_REPORT) {
        const bool dropped = dropping_;
        dropping_ = false;
        return dropped ? Outcome::dropped : Outcome::complete;
    }
    if (dropping_) {
        return Outcome::none;
    }
    if (event.type == EV_ABS) {
        set_axis(event.code, event.value);
    } else if (event.type == EV_KEY) {
        set_button(event.code, event.value != 0);
    }
    return Outcome::none;
}

int EvdevState::scaled(const input_absinfo& range) {
    const std::int64_t width = std::int64_t{range.maximum} - range.minimum;
    const std::int64_t place =
        std::clamp(std::int64_t{range.value} - range.minimum, std::int64_t{0}, width);
    return static_cast<int>(2 * kFullDeflection * place / width - kFullDeflection);
}

std::size_t EvdevState::write(std::span<std::uint8_t, kMostBytes> report, bool gone) {
    report[0] = kMagic;
    report[kReportFlagsAt] =
        static_cast<std::uint8_t>((gone ? kGone : 0) | (changed_ ? kChanged : 0));
    report[kAxisCountAt] = static_cast<std::uint8_t>(axes_);
    std::size_t at = kHeaderBytes;
    for (std::size_t axis = 0; axis < axes_; ++axis) {
        const auto position = static_cast<std::uint16_t>(scaled(ranges_[axis]));
        report[at] = static_cast<std::uint8_t>(codes_[axis]);
        report[at + 1] = static_cast<std::uint8_t>(position);
        report[at + 2] = static_cast<std::uint8_t>(position >> 8U);
        at += kAxisBytes;
    }
    std::size_t buttons = 0;
    for (std::size_t index = 0; index < pressed_.size() && buttons < kMostButtons; ++index) {
        if (pressed_[index] || pressed_since_report_[index]) {
            const std::size_t code = kFirstButton + index;
            report[at] = static_cast<std::uint8_t>(code);
            report[at + 1] = static_cast<std::uint8_t>(code >> 8U);
            at += kButtonBytes;
            ++buttons;
        }
    }
    report[kButtonCountAt] = static_cast<std::uint8_t>(buttons);
    pressed_since_report_.reset();
    changed_ = false;
    return at;
}

}  // namespace tribus
