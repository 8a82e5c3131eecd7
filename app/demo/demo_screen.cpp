#include "app/demo/demo_screen.h"

#include <algorithm>
#include <optional>
#include <string_view>
#include <vector>

#include <fmt/format.h>

namespace tribus {
namespace {

using namespace screen;

constexpr std::size_t kLabelWidth = 4;  // "18  "
constexpr std::size_t kNumberWidth = kPulseNumberWidth;
constexpr std::size_t kGap = 2;
constexpr std::size_t kTwoBarsFrom = 2 * (kNumberWidth + 10) + kLabelWidth + kGap;

std::string_view state_colour(const ChannelFrame& frame) {
    return frame.failsafe ? kRed : frame.frame_lost ? kYellow : kGreen;
}

std::optional<double> us_of(std::optional<Pulse> pulse) {
    return pulse ? std::optional(pulse->microseconds()) : std::nullopt;
}

/// Width of each bar if there are two.
std::size_t bar_width(const ScreenStyle& style) {
    return (style.columns - kLabelWidth - 2 * kNumberWidth - kGap - 1) / 2;
}

std::string channel_line(const DemoFigures& figures, const ScreenStyle& style,
                         std::size_t channel) {
    Line line(style);
    line.add(fmt::format("{:2}  ", channel + 1), kDim);
    const std::string_view colour = state_colour(figures.after);
    const std::optional<double> before = us_of(figures.before.channel(channel));
    const std::optional<double> after = us_of(figures.after.channel(channel));
    if (style.columns < kTwoBarsFrom) {
        const std::size_t used = kLabelWidth + kNumberWidth;
        line.add(pulse_number(after));
        line.add(bar(after, std::max<std::size_t>(style.columns, used + 3) - used, style.unicode),
                 colour);
        return line.take();
    }
    const std::size_t width = bar_width(style);
    line.add(pulse_number(before));
    line.add(bar(before, width, style.unicode), figures.link_up ? kGreen : kDim);
    line.add(std::string(kGap, ' '));
    line.add(pulse_number(after));
    line.add(bar(after, width, style.unicode), colour);
    return line.take();
}

std::vector<std::string> heading(const DemoFigures& figures, const ScreenStyle& style) {
    const std::string_view arrow = style.unicode ? " → " : " -> ";
    Line title(style);
    title.add("tribus demo", kBold);
    title.add(fmt::format("  i.Bus 18 ch {}{}SBUS {}  {:.0f} s  Ctrl-C ends", figures.input_device,
                          arrow, figures.output_device,
                          std::chrono::duration<double>(figures.elapsed).count()));
    Line state(style);
    state.add("radio ");
    state.add(figures.link_up ? "up  " : "DOWN", figures.link_up ? kGreen : kRed);
    state.add("  servos ");
    state.add(fmt::format("{:10}", state_word(figures.after)), state_colour(figures.after));
    state.add(fmt::format("  in {:.0f}/s  out {:.0f}/s  latency {} (p99 {})", figures.input_rate_hz,
                          figures.output_rate_hz, short_duration(figures.latency_p50),
                          short_duration(figures.latency_p99)));
    return {title.take(), state.take()};
}

std::string column_titles(const ScreenStyle& style) {
    Line line(style);
    const std::string indent(kLabelWidth + kNumberWidth, ' ');
    if (style.columns < kTwoBarsFrom) {
        line.add(indent + "SBUS, at the servos", kDim);
        return line.take();
    }
    line.add(fmt::format("{}{:{}}SBUS, at the servos", indent, "i.Bus, from the receiver",
                         bar_width(style) + kGap + kNumberWidth),
             kDim);
    return line.take();
}

std::string hidden_channels(std::size_t count, const ScreenStyle& style) {
    Line line(style);
    line.add(fmt::format("{} {} more channels", style.unicode ? "…" : "...", count), kDim);
    return line.take();
}

std::vector<std::string> closing(const DemoFigures& figures, const ScreenStyle& style) {
    Line counts(style);
    counts.add(fmt::format("frames {} in, {} out, ", figures.frames_in, figures.frames_out));
    counts.add(fmt::format("{} lost", figures.lost), figures.lost == 0 ? kGreen : kRed);
    Line drop(style);
    drop.add(figures.latest_drop.empty() ? "the radio link will drop in a moment"
                                         : figures.latest_drop);
    return {counts.take(), drop.take()};
}

}  // namespace

std::string state_word(const ChannelFrame& frame) {
    return frame.failsafe ? "failsafe" : frame.frame_lost ? "frame lost" : "good";
}

std::string draw_demo(const DemoFigures& figures, const ScreenStyle& style) {
    std::vector<std::string> lines = heading(figures, style);
    const std::vector<std::string> last = closing(figures, style);
    // One row stays free: a line feed in the last one would scroll.
    const std::size_t rows = std::max<std::size_t>(style.rows, 2) - 1;
    if (rows > lines.size() + kChannelCount + last.size()) {
        lines.push_back(column_titles(style));
    }
    const std::size_t fixed = lines.size() + last.size();
    std::size_t channels = rows > fixed ? std::min(kChannelCount, rows - fixed) : 0;
    const bool tells_hidden = channels > 1 && channels < kChannelCount;
    channels -= tells_hidden ? 1 : 0;
    for (std::size_t channel = 0; channel < channels; ++channel) {
        lines.push_back(channel_line(figures, style, channel));
    }
    if (tells_hidden) {
        lines.push_back(hidden_channels(kChannelCount - channels, style));
    }
    lines.insert(lines.end(), last.begin(), last.end());
    lines.resize(std::min(lines.size(), rows));
    std::string screen = "\x1b[H";
    for (const std::string& line : lines) {
        screen += line;
        screen += kEraseRest;
    }
    return screen + "\x1b[J";
}

std::string demo_line(const DemoFigures& figures) {
    const auto us = [](const ChannelFrame& frame, std::size_t channel) {
        return frame.channel_or(channel, Pulse{}).whole_microseconds();
    };
    return fmt::format(
        "{:5.1f} s  radio {:4}  servos {:10}  ch1 {:4} -> {:4}  ch2 {:4} -> {:4}  in {:.0f}/s  out "
        "{:.0f}/s  latency {}",
        std::chrono::duration<double>(figures.elapsed).count(), figures.link_up ? "up" : "down",
        state_word(figures.after), us(figures.before, 0), us(figures.after, 0),
        us(figures.before, 1), us(figures.after, 1), figures.input_rate_hz, figures.output_rate_hz,
        short_duration(figures.latency_p50));
}

}  // namespace tribus
