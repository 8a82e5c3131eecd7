#include "app/demo/demo_screen.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>
#include <string>
#include <vector>

namespace tribus::demo_screen_test {
namespace {

using namespace std::chrono_literals;

DemoFigures figures() {
    DemoFigures figures;
    figures.elapsed = 12s;
    figures.input_device = "/dev/pts/3";
    figures.output_device = "/dev/pts/5";
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        figures.before.set(channel, Pulse::from_microseconds(1200));
        figures.after.set(channel, Pulse::from_microseconds(1200));
    }
    figures.after.frame_lost = false;
    figures.after.failsafe = false;
    figures.latest_drop =
        "link dropped: frame lost after 94 ms, failsafe after 396 ms; control ...";
    return figures;
}

/// Returns the visible lines, without colours and other terminal sequences.
std::vector<std::string> visible_lines(const std::string& screen) {
    std::string text;
    for (std::size_t i = 0; i < screen.size(); ++i) {
        if (screen[i] == '\x1b') {
            i = screen.find_first_of("HJKmhl", i);
        } else if (screen[i] != '\r') {
            text += screen[i];
        }
    }
    std::vector<std::string> lines;
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);) {
        lines.push_back(line);
    }
    return lines;
}

std::size_t columns(const std::string& line) {
    return static_cast<std::size_t>(std::count_if(line.begin(), line.end(), [](char byte) {
        return (static_cast<unsigned char>(byte) & 0xC0U) != 0x80;
    }));
}

TEST(DemoScreen, FitsEveryTerminal) {
    for (std::size_t width = 1; width <= 200; ++width) {
        for (const std::size_t rows : {1U, 2U, 5U, 10U, 24U, 60U}) {
            for (const bool unicode : {false, true}) {
                const auto lines = visible_lines(
                    draw_demo(figures(), {.columns = width, .rows = rows, .unicode = unicode}));
                ASSERT_LE(lines.size(), std::max<std::size_t>(rows - 1, 1));
                for (const std::string& line : lines) {
                    ASSERT_LE(columns(line), width) << line;
                }
            }
        }
    }
}

TEST(DemoScreen, ShowsEveryChannelBeforeAndAfterOnAPlainTerminal) {
    const auto lines = visible_lines(draw_demo(figures(), {.columns = 80, .rows = 24}));
    ASSERT_EQ(lines.size(), 23U);
    for (std::size_t channel = 1; channel <= kChannelCount; ++channel) {
        const std::string& line = lines[2 + channel];
        EXPECT_EQ(std::stoul(line.substr(0, 2)), channel);
        EXPECT_NE(line.find("1200"), line.rfind("1200")) << line;
    }
}

TEST(DemoScreen, ALowTerminalCountsTheChannelsThatItHides) {
    const auto lines = visible_lines(draw_demo(figures(), {.columns = 80, .rows = 10}));
    ASSERT_EQ(lines.size(), 9U);
    EXPECT_EQ(lines[5].substr(0, 2), " 4");
    EXPECT_EQ(lines[6], "… 14 more channels");
}

TEST(DemoScreen, ANarrowTerminalKeepsWhatTheServosGet) {
    const auto lines = visible_lines(draw_demo(figures(), {.columns = 30, .rows = 24}));
    EXPECT_NE(lines[3].find("1200"), std::string::npos);
    EXPECT_EQ(lines[3].find("1200"), lines[3].rfind("1200"));
}

TEST(DemoScreen, WithoutUnicodeAndColourItIsPlainAscii) {
    const std::string screen =
        draw_demo(figures(), {.columns = 80, .rows = 24, .unicode = false, .colour = false});
    EXPECT_TRUE(std::all_of(screen.begin(), screen.end(),
                            [](char byte) { return static_cast<unsigned char>(byte) < 0x80; }));
    EXPECT_EQ(screen.find("\x1b[3"), std::string::npos);
}

}  // namespace
}  // namespace tribus::demo_screen_test
