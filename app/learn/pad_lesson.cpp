#include "app/learn/pad_lesson.h"

#include <linux/input-event-codes.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/channel_frame.h"
#include "core/gamepad_report.h"
#include "transports/codecs/gamepad/codes.h"

namespace tribus {

namespace {

using namespace std::chrono_literals;

/// Sticks of worn pads tremble by some hundredths of their way.
constexpr int kTremble = gamepad_report::kFullDeflection / 20;
/// An axis that went so far was meant.
constexpr int kFar = gamepad_report::kFullDeflection * 6 / 10;
/// A stick that came back so near was let go.
constexpr int kNear = gamepad_report::kFullDeflection * 3 / 10;
constexpr Duration kRestTime = 1s;
/// A lever stays where it was moved to.
constexpr Duration kLeverTime = 2s;
constexpr Duration kShortPress = 700ms;
constexpr Duration kDeadManTime = 1s;
constexpr std::size_t kStickChannels = 4;
constexpr std::array<std::string_view, kStickChannels> kStickOrders{
    "aileron or steering (right)", "elevator (towards you)", "throttle (full)", "rudder (right)"};

bool has_code(std::span<const std::uint16_t> codes, std::uint16_t code) {
    return std::ranges::find(codes, code) != codes.end();
}

std::string axis_text(std::uint16_t code) {
    const std::string_view name = gamepad_axis_name(code);
    return name.empty() ? fmt::format("the axis with the code {:X}", code) : std::string(name);
}

std::string button_text(std::uint16_t code) {
    const std::string name = gamepad_button_name(code);
    return name.empty() ? fmt::format("the button with the code {:X}", code) : name;
}

std::string channel_text(std::string_view name, std::size_t channel, std::string_view flag) {
    return flag.empty()
               ? fmt::format("{} = {}", name, channel + 1)
               : fmt::format("{} = {{ channel = {}, {} = true }}", name, channel + 1, flag);
}

std::string table_of_channels(const std::vector<std::string>& entries) {
    return entries.empty() ? "{}" : fmt::format("{{ {} }}", fmt::join(entries, ", "));
}

}  // namespace

std::optional<PadSight> pad_sight_of(std::span<const std::uint8_t> report) {
    if (report.size() < gamepad_report::kHeaderBytes || report[0] != gamepad_report::kMagic) {
        return std::nullopt;
    }
    const std::size_t axes = report[gamepad_report::kAxisCountAt];
    const std::size_t buttons = report[gamepad_report::kButtonCountAt];
    if (report.size() != gamepad_report::kHeaderBytes + gamepad_report::kAxisBytes * axes +
                             gamepad_report::kButtonBytes * buttons) {
        return std::nullopt;
    }
    PadSight sight{.axes = {},
                   .pressed = {},
                   .gone = (report[gamepad_report::kReportFlagsAt] & gamepad_report::kGone) != 0};
    std::span<const std::uint8_t> rest = report.subspan(gamepad_report::kHeaderBytes);
    for (std::size_t axis = 0; axis < axes;
         ++axis, rest = rest.subspan(gamepad_report::kAxisBytes)) {
        const auto position = static_cast<std::int16_t>(rest[1] | rest[2] << 8);
        sight.axes.push_back({.code = rest[0], .position = position});
    }
    for (std::size_t button = 0; button < buttons;
         ++button, rest = rest.subspan(gamepad_report::kButtonBytes)) {
        sight.pressed.push_back(static_cast<std::uint16_t>(rest[0] | rest[1] << 8));
    }
    return sight;
}

std::string PadLesson::prompt() const {
    switch (step_) {
        case PadStep::rest:
            return "Let go of all sticks, triggers and buttons.";
        case PadStep::channel:
            break;
        case PadStep::dead_man:
            return "Dead man's button: hold the button for a second that must be held while a "
                   "machine moves.";
        case PadStep::done:
            return {};
    }
    if (channel_ < kStickChannels) {
        return fmt::format(
            "Channel {}, {}: move its stick to the end that shall be 2000 us, and "
            "let go.",
            channel_ + 1, kStickOrders[channel_]);
    }
    return fmt::format(
        "Channel {}: press a button, or move a stick or trigger to the end that shall be 2000 us. "
        "With a short press each press changes the channel; with a press of a second it is 2000 us "
        "while the button is pressed.",
        channel_ + 1);
}

std::string PadLesson::left_out() const {
    return step_ == PadStep::dead_man  ? "there is none"
           : channel_ < kStickChannels ? "this channel is left out"
                                       : "there are no more channels";
}

void PadLesson::begin(PadStep step, Instant now) {
    step_ = step;
    refused_ = false;
    button_.reset();
    at_begin_ = latest_;
    before_moved_ = latest_;
    moved_at_ = now;
    travel_.assign(latest_.axes.size(), 0);
}

void PadLesson::refuse(const std::string& text) {
    refused_ = true;
    remark(text);
}

void PadLesson::remark(const std::string& text) {
    remark_ += (remark_.empty() ? "" : " ") + text;
}

std::string PadLesson::take_remark() {
    return std::exchange(remark_, {});
}

bool PadLesson::has_moved(const PadSight& sight) const {
    for (std::size_t i = 0; i < sight.axes.size(); ++i) {
        if (std::abs(sight.axes[i].position - before_moved_.axes[i].position) > kTremble) {
            return true;
        }
    }
    return sight.pressed != before_moved_.pressed;
}

void PadLesson::see(const PadSight& sight, Instant now) {
    if (!has_seen_ || sight.axes.size() != latest_.axes.size()) {
        has_seen_ = true;
        latest_ = sight;
        begin(step_, now);
    }
    if (has_moved(sight)) {
        before_moved_ = sight;
        moved_at_ = now;
    }
    see_axes(sight);
    see_buttons(sight, now);
    latest_ = sight;
    say_why_not();
}

void PadLesson::see_axes(const PadSight& sight) {
    for (std::size_t i = 0; i < sight.axes.size(); ++i) {
        const int travel = sight.axes[i].position - at_begin_.axes[i].position;
        if (std::abs(travel) > std::abs(travel_[i])) {
            travel_[i] = travel;
        }
    }
}

void PadLesson::see_buttons(const PadSight& sight, Instant now) {
    for (const std::uint16_t code : sight.pressed) {
        if (!has_code(latest_.pressed, code)) {
            see_press(code, now);
        }
    }
    for (const std::uint16_t code : latest_.pressed) {
        if (!has_code(sight.pressed, code)) {
            see_release(code, now);
        }
    }
}

void PadLesson::see_press(std::uint16_t code, Instant now) {
    const bool wanted =
        step_ == PadStep::dead_man || (step_ == PadStep::channel && channel_ >= kStickChannels);
    if (!wanted || button_) {
        return;
    }
    if (const auto channel = channel_of_button(code)) {
        refuse(fmt::format("{} is channel {} already; take another.", button_text(code),
                           *channel + 1));
    } else if (gamepad_button_name(code).empty()) {
        refuse(fmt::format("A configuration has no name for {}; take another.", button_text(code)));
    } else {
        button_ = ShownButton{.code = code, .since = now};
    }
}

void PadLesson::see_release(std::uint16_t code, Instant now) {
    if (!button_ || button_->code != code || button_->held) {
        return;
    }
    button_->held = now - button_->since;
    if (step_ == PadStep::dead_man && *button_->held < kDeadManTime) {
        refuse(fmt::format("{} was released too early; hold it for a second.", button_text(code)));
        button_.reset();
    }
}

bool PadLesson::is_let_go() const {
    for (std::size_t i = 0; i < latest_.axes.size(); ++i) {
        if (std::abs(latest_.axes[i].position - at_begin_.axes[i].position) > kNear) {
            return false;
        }
    }
    return latest_.pressed.empty();
}

/// The axis that was moved furthest among those without a channel; none if two went alike.
std::optional<GamepadAxis> PadLesson::shown_axis() const {
    std::optional<GamepadAxis> shown;
    int furthest = 0;
    int second = 0;
    for (std::size_t i = 0; i < travel_.size(); ++i) {
        const std::uint16_t code = latest_.axes[i].code;
        const int way = std::abs(travel_[i]);
        if (channel_of_axis(code) || gamepad_axis_name(code).empty()) {
            continue;
        }
        second = std::max(second, std::min(way, furthest));
        if (way > furthest) {
            furthest = way;
            shown = GamepadAxis{.code = code, .channel = channel_, .reverse = travel_[i] < 0};
        }
    }
    return furthest >= kFar && 3 * second < 2 * furthest ? shown : std::nullopt;
}

/// Axes that were moved and let go, but cannot be taken.
void PadLesson::say_why_not() {
    if (step_ != PadStep::channel || !is_let_go() || shown_axis()) {
        return;
    }
    std::vector<std::string> alike;
    for (std::size_t i = 0; i < travel_.size(); ++i) {
        const std::uint16_t code = latest_.axes[i].code;
        if (std::abs(travel_[i]) < kFar) {
            continue;
        }
        if (const auto channel = channel_of_axis(code)) {
            refuse(fmt::format("{} is channel {} already; take another.", axis_text(code),
                               *channel + 1));
        } else if (gamepad_axis_name(code).empty()) {
            refuse(
                fmt::format("A configuration has no name for {}; take another.", axis_text(code)));
        } else {
            alike.push_back(axis_text(code));
        }
    }
    if (alike.size() > 1) {
        refuse(fmt::format("{} moved alike; move one.", fmt::join(alike, " and ")));
    }
    const auto was_far = [](int travel) { return std::abs(travel) >= kFar; };
    if (std::ranges::any_of(travel_, was_far)) {
        travel_.assign(travel_.size(), 0);
    }
}

std::optional<std::size_t> PadLesson::channel_of_axis(std::uint16_t code) const {
    const auto found = std::ranges::find(learned_.axes, code, &GamepadAxis::code);
    return found == learned_.axes.end() ? std::nullopt : std::optional(found->channel);
}

std::optional<std::size_t> PadLesson::channel_of_button(std::uint16_t code) const {
    const auto found = std::ranges::find(learned_.buttons, code, &GamepadButton::code);
    return found == learned_.buttons.end() ? std::nullopt : std::optional(found->channel);
}

bool PadLesson::is_complete(Instant now) const {
    if (!has_seen_) {
        return false;
    }
    switch (step_) {
        case PadStep::rest:
            return latest_.pressed.empty() && now - moved_at_ >= kRestTime;
        case PadStep::channel:
            break;
        case PadStep::dead_man:
            return button_ && now - button_->since >= kDeadManTime;
        case PadStep::done:
            return false;
    }
    const bool is_lever = latest_.pressed.empty() && now - moved_at_ >= kLeverTime;
    return (shown_axis() || (button_ && button_->held)) && (is_let_go() || is_lever);
}

void PadLesson::leave_rest(Instant now) {
    if (is_complete(now)) {
        begin(PadStep::channel, now);
    } else {
        remark(latest_.pressed.empty()
                   ? "The sticks still move. Let go and wait for a second."
                   : fmt::format("{} is pressed. Release it.", button_text(latest_.pressed[0])));
        begin(PadStep::rest, now);
    }
}

void PadLesson::leave_channel(Instant now) {
    const auto axis = shown_axis();
    if (axis) {
        learned_.axes.push_back(*axis);
        remark(fmt::format("Channel {} is {}{}.", channel_ + 1, axis_text(axis->code),
                           axis->reverse ? ", reversed" : ""));
    } else if (button_) {
        const bool toggles = button_->held.value_or(now - button_->since) < kShortPress;
        learned_.buttons.push_back(
            {.code = button_->code, .channel = channel_, .toggles = toggles});
        remark(fmt::format("Channel {} is {}{}.", channel_ + 1, button_text(button_->code),
                           toggles ? ", changed by each press" : ", while it is pressed"));
    }
    const bool shown = axis || button_;
    if (!shown && refused_) {
        begin(PadStep::channel, now);
        return;
    }
    const bool last = !shown && channel_ >= kStickChannels;
    ++channel_;
    begin(last || channel_ == kChannelCount ? PadStep::dead_man : PadStep::channel, now);
}

void PadLesson::next(Instant now) {
    switch (step_) {
        case PadStep::rest:
            leave_rest(now);
            break;
        case PadStep::channel:
            leave_channel(now);
            break;
        case PadStep::dead_man:
            if (is_complete(now)) {
                learned_.dead_man = button_->code;
                remark(fmt::format("The dead man's button is {}.", button_text(button_->code)));
            }
            begin(learned_.dead_man || !refused_ ? PadStep::done : PadStep::dead_man, now);
            break;
        case PadStep::done:
            break;
    }
}

std::vector<std::string> pad_lines(const GamepadSettings& learned) {
    std::vector<std::string> axes;
    for (const GamepadAxis& axis : learned.axes) {
        axes.push_back(channel_text(gamepad_axis_name(axis.code), axis.channel,
                                    axis.reverse ? "reverse" : ""));
    }
    std::vector<std::string> buttons;
    for (const GamepadButton& button : learned.buttons) {
        buttons.push_back(channel_text(gamepad_button_name(button.code), button.channel,
                                       button.toggles ? "toggle" : ""));
    }
    // Absent tables would be the defaults, not empty ones.
    std::vector<std::string> lines{"axes     = " + table_of_channels(axes),
                                   "buttons  = " + table_of_channels(buttons)};
    if (learned.dead_man) {
        lines.push_back(fmt::format("dead_man = \"{}\"", gamepad_button_name(*learned.dead_man)));
    }
    return lines;
}

std::string dead_man_for(const GamepadSettings& learned, std::span<const std::uint16_t> buttons) {
    constexpr std::array<std::uint16_t, 6> kHandy{BTN_TL,  BTN_TR,      BTN_TL2,
                                                  BTN_TR2, BTN_TRIGGER, BTN_THUMB};
    for (const std::uint16_t code : kHandy) {
        const bool used =
            std::ranges::find(learned.buttons, code, &GamepadButton::code) != learned.buttons.end();
        if (has_code(buttons, code) && !used) {
            return gamepad_button_name(code);
        }
    }
    return {};
}

}  // namespace tribus
