#include "tests/support/page_examples.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <regex>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/shell.h"

/// What docs/ shows as printed by a command is what the command prints. The files are those that
/// docs/commands.md, "Files for the examples", says how to make.
namespace tribus::test::page_examples_test {
namespace {

/// Commands that print the same at each run.
constexpr std::string_view kSameAtEachRun =
    "^tribus (check|graph|decode|simulate|dbc|learn sbus\\.toml)\\b|\\| tribus encode\\b";
/// Commands of which live_page_examples_test.cpp compares the words.
constexpr std::string_view kLive =
    "^(sudo )?tribus (init|run|monitor|status|diff|key new|doctor|record|replay|demo|bench)\\b";
/// Commands that need a terminal, a paired browser or a gamepad; lab/ and loopback/ have tests of
/// what these print.
constexpr std::string_view kNeedsAPerson = "^tribus (reload --trial|pair --list|learn /dev/input)";

bool is(const PageExample& example, std::string_view kind) {
    return std::regex_search(example.command, std::regex(kind.begin(), kind.end()));
}

std::string replaced(std::string text, std::string_view what, std::string_view with) {
    const std::size_t at = text.find(what);
    EXPECT_NE(at, std::string::npos) << what;
    return at == std::string::npos ? text : text.replace(at, what.size(), with);
}

class PageExamples : public testing::Test {
  protected:
    /// Makes the files of the examples with the lines of the page itself.
    PageExamples() {
        const auto page = readme().parent_path() / "docs" / "commands.md";
        for (const Fence& fence : fences_of(page)) {
            if (fence.language == "toml" && fence.text.find("/tmp/receiver") != std::string::npos) {
                servos_ = fence.text;
            } else if (fence.language == "sh" && fence.text.find("> ") != std::string::npos &&
                       fence.text.find("/dev/") == std::string::npos &&
                       fence.text.find("in.txt") == std::string::npos) {
                makers_.push_back(fence.text);
            }
        }
        folder_.write("servos.toml", servos_);
        folder_.write("sbus.toml", replaced(servos_, "\"ibus\"", "\"sbus\""));
        folder_.write("bad.toml", replaced(replaced(servos_, "\"ibus\"", "\"ibuz\""),
                                           "from = \"receiver\"", "from = \"reciever\""));
        for (const std::string& maker : makers_) {
            const Ended made = run(maker);
            EXPECT_EQ(made.status, 0) << maker << made.output;
        }
    }
    Ended run(const std::string& command) const {
        return run_in_shell("cd '" + folder_ / "" + "'; tribus() { \"$TRIBUS\" \"$@\"; }; " +
                            command);
    }

    TemporaryFolder folder_;
    std::string servos_;
    std::vector<std::string> makers_;
};

TEST_F(PageExamples, AreWhatTheCommandsPrint) {
    EXPECT_EQ(makers_.size(), 3U);
    std::size_t found = 0;
    for (const PageExample& example : examples_of_the_program()) {
        if (is(example, kSameAtEachRun)) {
            ++found;
            const Ended ended = run(example.command);
            EXPECT_TRUE(prints_exactly(example.output, ended.output))
                << example.where << ": $ " << example.command << "\n"
                << ended.output;
        }
    }
    EXPECT_GE(found, 10U);
}

/// A page that shows the files that a command reads, and what it prints.
struct PageWithFiles {
    std::string page;
    std::string command;
};

class PageExamplesOfFiles : public testing::TestWithParam<PageWithFiles> {};

INSTANTIATE_TEST_SUITE_P(
    Shown, PageExamplesOfFiles,
    testing::Values(PageWithFiles{"can.md", "tribus decode --as pages.toml:bus pages.log"},
                    PageWithFiles{"sensor-bus.md", "tribus decode --protocol ibus-sensor sens.txt"},
                    PageWithFiles{"dronecan.md", "tribus decode --protocol dronecan drone.log"},
                    PageWithFiles{
                        "telemetry.md",
                        "tribus simulate telemetry.toml --in battery=battery.log "
                        "--in telemetry=requests.txt --out telemetry=answers.txt > /dev/null 2>&1; "
                        "sort -n requests.txt answers.txt | tribus decode --protocol ibus-sensor"}),
    [](const auto& test) {
        return test.param.page.substr(0, test.param.page.find_first_of("-."));
    });

TEST_P(PageExamplesOfFiles, AreWhatTheCommandsPrint) {
    static const std::regex name("`([a-z]+\\.(log|txt)|pages\\.(dbc|toml))`");
    const auto root = readme().parent_path();
    TemporaryFolder folder;
    for (const char* const file : {"telemetry.toml", "telemetry.dbc"}) {
        std::filesystem::copy_file(root / "config" / "examples" / file, folder / file);
    }
    std::string shown;
    for (const Fence& fence : fences_of(root / "docs" / GetParam().page)) {
        std::smatch match;
        const bool plain = fence.language.empty();
        if (plain && fence.text.starts_with("        t_us")) {
            shown = fence.text;
        } else if ((plain || fence.language == "toml") &&
                   std::regex_search(fence.title, match, name)) {
            folder.write(match[1], fence.text);
        }
    }
    ASSERT_NE(shown, "");
    const Ended ended = run_in_shell("cd '" + folder / "" +
                                     "'; tribus() { \"$TRIBUS\" \"$@\"; }; " + GetParam().command);
    EXPECT_EQ(ended.status, 0);
    EXPECT_TRUE(prints_exactly(shown, ended.output)) << ended.output;
}

TEST_F(PageExamples, AreAllOfAKindThatIsTested) {
    std::size_t found = 0;
    for (const PageExample& example : examples_of_the_program()) {
        ++found;
        const auto kinds = {kSameAtEachRun, kLive, kNeedsAPerson};
        EXPECT_EQ(std::ranges::count_if(kinds, [&](auto kind) { return is(example, kind); }), 1)
            << example.where << ": " << example.command;
    }
    EXPECT_GE(found, 24U);
}

TEST(PageExample, MatchesWithItsGapsFromBeginToEnd) {
    EXPECT_TRUE(prints_exactly("a 1\n...\nc\n", "a 1\nb\nb\nc\n"));
    EXPECT_TRUE(prints_exactly("a ...  z\nc\n", "a b c  z\nc\n"));
    EXPECT_TRUE(prints_exactly("a\n...\n", "a\nb\n"));
    EXPECT_FALSE(prints_exactly("a 1\n...\nc\n", "a 2\nb\nc\n"));
    EXPECT_FALSE(prints_exactly("a\n", "a\nb\n"));
    EXPECT_FALSE(prints_exactly("...\nb\n", "a\nb\nc\n"));
    EXPECT_FALSE(prints_exactly("", "a\n"));
}

TEST(PageExample, ComparesWordsWhateverTheNumbersAndBreaks) {
    EXPECT_TRUE(prints_the_words("/dev/pts/1: 357 frames in\n 2.7 s\n...\n",
                                 "/tmp/x: 9 frames in 13 ms\nmore\n"));
    EXPECT_FALSE(prints_the_words("7 frames\n", "7 bursts\n"));
    EXPECT_FALSE(prints_the_words("7 frames\n", "7 frames, 1 rejected\n"));
}

}  // namespace
}  // namespace tribus::test::page_examples_test
