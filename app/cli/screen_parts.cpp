#include "app/cli/screen_parts.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include <fmt/format.h>

namespace tribus::screen {
namespace {

constexpr double kBarLeastUs = 900;
constexpr double kBarMostUs = 2100;

}  // namespace

std::size_t control_length(std::string_view text) {
    constexpr unsigned char kDelete = 0x7F;
    constexpr unsigned char kFirstOfLatin = 0xC2;
    constexpr unsigned char kAboveControls = 0xA0;
    const auto byte = [&](std::size_t i) {
        return i < text.size() ? static_cast<unsigned char>(text[i]) : kAboveControls;
    };
    if (byte(0) < ' ' || byte(0) == kDelete) {
        return 1;
    }
    return byte(0) == kFirstOfLatin && byte(1) < kAboveControls ? 2 : 0;
}

std::string_view cut_mark(const ScreenStyle& style) {
    return style.unicode ? "…" : ">";
}

void Line::add(std::string_view text, std::string_view colour) {
    const bool coloured = style_.colour && !colour.empty() && !text.empty();
    text_ += coloured ? colour : std::string_view();
    std::size_t i = 0;
    for (; i < text.size() && width_ < style_.columns; ++width_) {
        std::size_t length = 1;
        while (i + length < text.size() && (text[i + length] & 0xC0) == 0x80) {
            ++length;
        }
        const std::string_view shown =
            control_length(text.substr(i)) > 0 ? std::string_view("?") : text.substr(i, length);
        last_at_ = text_.size();
        last_length_ = shown.size();
        text_ += shown;
        i += length;
    }
    text_ += coloured ? kReset : std::string_view();
    if (text.find_first_not_of(' ', i) != std::string_view::npos) {
        mark_cut();
    }
}

void Line::mark_cut() {
    if (!cut_ && width_ > 0) {
        text_.replace(last_at_, last_length_, cut_mark(style_));
        cut_ = true;
    }
}

std::string bar(std::optional<double> pulse_us, std::size_t width, bool unicode) {
    const std::string_view rest = unicode ? "·" : "-";
    const std::string_view centre = unicode ? "│" : "|";
    const std::string_view fill = unicode ? "━" : "=";
    const std::string_view block = unicode ? "█" : "#";
    const std::size_t middle = width / 2;
    std::size_t at = middle;
    if (pulse_us) {
        const double share = (*pulse_us - kBarLeastUs) / (kBarMostUs - kBarLeastUs);
        const double last = static_cast<double>(width - 1);
        at = static_cast<std::size_t>(std::lround(std::clamp(share, 0.0, 1.0) * last));
    }
    std::string text;
    for (std::size_t i = 0; i < width; ++i) {
        const bool filled = std::min(at, middle) < i && i < std::max(at, middle);
        text += pulse_us && i == at ? block : i == middle ? centre : filled ? fill : rest;
    }
    return text;
}

std::string bar_scale(std::size_t width) {
    const auto number = [](double us) { return fmt::format("{:.0f}", us); };
    const std::string least = number(kBarLeastUs);
    const std::string centre = number((kBarLeastUs + kBarMostUs) / 2);
    const std::string most = number(kBarMostUs);
    std::string text(width, ' ');
    if (width > least.size() + most.size()) {
        text.replace(0, least.size(), least);
        text.replace(width - most.size(), most.size(), most);
    }
    if (width > 2 * (least.size() + most.size()) + centre.size()) {
        text.replace(width / 2 - centre.size() / 2, centre.size(), centre);
    }
    return text;
}

std::string pulse_number(std::optional<double> pulse_us) {
    return pulse_us ? fmt::format("{:4} ", std::lround(*pulse_us)) : "   - ";
}

}  // namespace tribus::screen

namespace tribus {

std::string short_duration(Duration duration) {
    const double us = std::chrono::duration<double, std::micro>(duration).count();
    constexpr double kThousand = 1000;
    if (us < kThousand) {
        return fmt::format("{:.0f} us", us);
    }
    const double ms = us / kThousand;
    return ms < 10          ? fmt::format("{:.1f} ms", ms)
           : ms < kThousand ? fmt::format("{:.0f} ms", ms)
                            : fmt::format("{:.2f} s", ms / kThousand);
}

}  // namespace tribus
