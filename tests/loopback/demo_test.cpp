#include <sys/ioctl.h>
#include <termios.h>

#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <ostream>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/loopback/loopback.h"

namespace tribus::test::demo_test {
namespace {

/// A terminal window of this size, which is the program's standard output.
struct Window {
    std::size_t columns;
    std::size_t rows;
};

std::ostream& operator<<(std::ostream& out, const Window& window) {
    return out << window.columns << " columns, " << window.rows << " rows";
}

/// Returns the number of characters of a line that are visible, without colours and escape
/// sequences.
std::size_t visible_width(const std::string& line) {
    static const std::regex escapes("\x1b\\[[0-9;?]*[A-Za-z]");
    std::size_t width = 0;
    for (const char letter : std::regex_replace(line, escapes, "")) {
        const bool follows_in_utf8 = (static_cast<unsigned char>(letter) & 0xC0U) == 0x80U;
        width += letter == '\r' || follows_in_utf8 ? 0 : 1;
    }
    return width;
}

std::vector<std::string> split(const std::string& text, const std::string& at) {
    std::vector<std::string> parts;
    std::size_t start = 0;
    for (std::size_t end = 0; end != std::string::npos; start = end + at.size()) {
        end = text.find(at, start);
        parts.push_back(text.substr(start, end == std::string::npos ? end : end - start));
    }
    return parts;
}

class Demo : public Loopback {};

TEST_F(Demo, FarEndsAreForAnotherTribus) {
    const std::string file = folder() / "demo.toml";
    Program& far_ends = start({"demo", "--far-ends", file});
    EXPECT_TRUE(eventually([&] { return std::filesystem::exists(file); }));
    Program& program = start({"run", file});
    EXPECT_TRUE(program.says("output servos: under control of receiver")) << program.errors();
    far_ends.signal(SIGTERM);
    EXPECT_EQ(far_ends.end(), 0);
    EXPECT_TRUE(program.says("cannot send: its device is gone")) << program.errors();
}

/// The demo drops the link after 6 s for 1.5 s.
TEST_F(Demo, WithoutATerminalPrintsPlainLinesAndRecoversFromTheDroppedLink) {
    Program& program = start({"demo", "--seconds", "9"});
    EXPECT_EQ(program.end(), 0) << program.errors();
    const std::regex drop(
        "link dropped: frame lost after [^.]+, failsafe after [^;]+; "
        "control back after [0-9].*");
    const std::string output = program.output();
    EXPECT_TRUE(std::regex_search(output, drop)) << output;
    EXPECT_EQ(count_of("lost:     0\n", output), 1U) << output;
    EXPECT_EQ(count_of("\x1b", output), 0U) << "there are control characters in plain lines";
    EXPECT_GE(count_of("  radio up ", output), 2U) << output;
    EXPECT_EQ(count_of("latency, receiver's write to servos' read: p50 ", output), 1U) << output;
    expect_no_allocation(program);
}

class DemoInAWindow : public Demo, public testing::WithParamInterface<Window> {
  protected:
    /// Returns what the program shows until it ends. At the third picture a user presses `key`.
    std::string show(Program& program, FarEnd& terminal, std::uint8_t key) {
        std::string shown;
        bool pressed = false;
        EXPECT_TRUE(eventually([&] {
            const Bytes bytes = terminal.receive();
            shown.append(bytes.begin(), bytes.end());
            if (!pressed && count_of("\x1b[H", shown) >= 3) {
                pressed = true;
                EXPECT_TRUE(terminal.send(Bytes{key}));
            }
            return !program.runs();
        }));
        const Bytes bytes = terminal.receive();
        shown.append(bytes.begin(), bytes.end());
        return shown;
    }
};

TEST_P(DemoInAWindow, KeepsToTheWindowAndEndsByCtrlCWithASummary) {
    ::setenv("LC_ALL", "C.UTF-8", 1);
    ::setenv("TERM", "xterm", 1);
    FarEnd& terminal = device("terminal");
    winsize size{};
    size.ws_col = static_cast<unsigned short>(GetParam().columns);
    size.ws_row = static_cast<unsigned short>(GetParam().rows);
    ASSERT_EQ(::ioctl(terminal.descriptor(), TIOCSWINSZ, &size), 0);
    Program program(folder(), {"demo", "--seconds", "60"},
                    {.executable = TRIBUS_PROGRAM, .terminal = terminal.path()});
    const std::string shown = show(program, terminal, 0x03);
    EXPECT_EQ(program.end(), 0) << program.errors() << shown;

    const std::size_t leave = shown.find("\x1b[?1049l");
    ASSERT_NE(leave, std::string::npos) << "the alternate screen stays";
    const std::vector<std::string> pictures = split(shown.substr(0, leave), "\x1b[H");
    ASSERT_GE(pictures.size(), 4U);
    for (std::size_t i = 1; i < pictures.size(); ++i) {
        const std::vector<std::string> lines = split(pictures[i], "\n");
        EXPECT_LE(lines.size(), GetParam().rows);
        for (const std::string& line : lines) {
            EXPECT_LE(visible_width(line), GetParam().columns) << line;
        }
    }
    EXPECT_LT(shown.rfind("\x1b[?25l"), shown.rfind("\x1b[?25h")) << "the cursor stays hidden";
    EXPECT_EQ(count_of("lost:     0\r\n", shown.substr(leave)), 1U) << shown.substr(leave);
    expect_no_allocation(program);
}

INSTANTIATE_TEST_SUITE_P(Sizes, DemoInAWindow,
                         testing::Values(Window{40, 10}, Window{80, 24}, Window{20, 3}),
                         [](const auto& size) {
                             return std::to_string(size.param.columns) + "x" +
                                    std::to_string(size.param.rows);
                         });

}  // namespace
}  // namespace tribus::test::demo_test
