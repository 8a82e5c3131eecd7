#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/shell.h"

namespace tribus::test::help_test {
namespace {

std::string help_of(const std::string& command) {
    const Ended ended = run_in_shell("\"$TRIBUS\" " + command + " --help");
    EXPECT_EQ(ended.status, 0) << command;
    return ended.output;
}

std::vector<std::string> lines_of(const std::string& text) {
    std::istringstream stream(text);
    std::vector<std::string> lines;
    for (std::string line; std::getline(stream, line);) {
        lines.push_back(line);
    }
    return lines;
}

std::vector<std::string> commands() {
    std::vector<std::string> names{""};
    bool listed = false;
    for (const std::string& line : lines_of(help_of(""))) {
        if (listed && line.starts_with("  ") && line.size() > 2 && line[2] != ' ') {
            names.push_back(line.substr(2, line.find(' ', 2) - 2));
        }
        listed = listed || line == "Subcommands:";
    }
    return names;
}

TEST(Help, of_every_command_keeps_to_80_columns) {
    const std::vector<std::string> all = commands();
    ASSERT_GE(all.size(), 15U);
    for (const std::string& command : all) {
        for (const std::string& line : lines_of(help_of(command))) {
            EXPECT_LE(line.size(), 80U) << "tribus " << command << " --help: " << line;
        }
    }
}

TEST(Help, goes_on_under_the_text_of_an_option) {
    const std::string help = help_of("decode");
    const std::size_t at = help.find("\n  --as ");
    ASSERT_NE(at, std::string::npos);
    const std::string next = help.substr(help.find('\n', at + 1) + 1, 31);
    EXPECT_EQ(next.find_first_not_of(' '), 30U) << help;
}

}  // namespace
}  // namespace tribus::test::help_test
