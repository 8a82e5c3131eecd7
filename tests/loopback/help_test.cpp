#include <map>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/pages.h"
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

/// What a page shows as typed: blocks for a shell or of plain text, and words in ` `.
std::string typed_text_in(const std::filesystem::path& page) {
    std::string text;
    for (const Fence& fence : fences_of(page)) {
        text += fence.language.empty() || fence.language == "sh" ? fence.text : "";
    }
    static const std::regex inline_code("`([^`\n]+)`");
    const std::string all = text_of_file(page);
    for (std::sregex_iterator match(all.begin(), all.end(), inline_code), none; match != none;
         ++match) {
        text += (*match)[1].str() + "\n";
    }
    return text;
}

TEST(Help, knows_every_command_and_option_that_a_page_names) {
    static const std::regex call_form(R"((?:^|[\n$ /(])tribus ([a-z]+)(?=[ \n])([^\n|;)]*))");
    static const std::regex option_form(R"((?:^| )(--[a-z][a-z0-9_-]*))");
    std::map<std::string, std::string> help;
    for (const std::string& command : commands()) {
        help[command] = help_of(command);
    }
    std::size_t found = 0;
    for (const auto& page : manual_pages()) {
        const std::string text = typed_text_in(page);
        for (std::sregex_iterator call(text.begin(), text.end(), call_form), none; call != none;
             ++call) {
            ++found;
            const auto known = help.find((*call)[1]);
            EXPECT_NE(known, help.end()) << page << ":" << call->str();
            const std::string words = (*call)[2];
            for (std::sregex_iterator option(words.begin(), words.end(), option_form), no_option;
                 option != no_option && known != help.end(); ++option) {
                EXPECT_NE(known->second.find((*option)[1].str()), std::string::npos)
                    << page << ":" << call->str();
            }
        }
    }
    EXPECT_GE(found, 50U);
}

}  // namespace
}  // namespace tribus::test::help_test
