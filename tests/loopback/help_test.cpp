#include <map>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/pages.h"
#include "tests/support/program_help.h"
#include "tests/support/shell.h"

namespace tribus::test::help_test {
namespace {

/// Each program by its name.
const std::map<std::string, std::string> kPrograms{
    {"tribus", TRIBUS_PROGRAM}, {"tribus-web", TRIBUS_WEB}, {"tribus-mqtt", TRIBUS_MQTT}};

std::string help_of(const std::string& program, const std::string& words) {
    const Ended ended = run_in_shell("'" + kPrograms.at(program) + "' " + words + " --help");
    EXPECT_EQ(ended.status, 0) << program << " " << words;
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

/// The help of a command, with that of each protocol whose settings are its options.
std::string whole_help_of(const std::string& program, const std::string& command) {
    std::string help = help_of(program, command);
    if (command == "decode" || command == "encode") {
        const Ended offered = run_in_shell("\"$TRIBUS\" --complete " + command + " --protocol ''");
        for (const std::string& protocol : lines_of(offered.output)) {
            help += help_of(program, command + " --protocol " + protocol);
        }
    }
    return help;
}

/// The texts are tested in programs_test.cpp, without the programs.
TEST(Help, IsThatOfTheProgramForEveryCommand) {
    for (const auto& [program, path] : kPrograms) {
        const std::vector<std::string> commands = commands_of(path);
        ASSERT_FALSE(commands.empty()) << program;
        EXPECT_TRUE(help_of(program, "").starts_with("Usage: " + program + " "));
        for (const std::string& command : commands) {
            const std::string help = help_of(program, command);
            EXPECT_TRUE(help.starts_with("Usage: " + program + " " + command + " ")) << help;
        }
    }
    EXPECT_GE(commands_of(TRIBUS_PROGRAM).size(), 20U);
}

TEST(Help, NamesTheProtocolsAndShowsTheSettingsOfOne) {
    const std::string help = help_of("tribus", "decode");
    EXPECT_EQ(help.find("--slots"), help.npos);
    EXPECT_NE(help.find("crsf-telemetry"), help.npos);
    EXPECT_NE(help.find("`tribus decode --protocol sbus --help`"), help.npos);
    const std::string ibus = help_of("tribus", "decode --protocol ibus");
    EXPECT_NE(ibus.find("\n  --slots "), ibus.npos) << ibus;
    EXPECT_EQ(ibus.find("--scale"), ibus.npos) << ibus;
}

TEST(Version, IsThatOfTheProjectAndSaysHowEachProgramWasBuilt) {
    const std::string source = TRIBUS_SOURCE_DIR;
    std::smatch version;
    const std::string project = text_of_file(source + "/CMakeLists.txt");
    ASSERT_TRUE(
        std::regex_search(project, version, std::regex("project\\(tribus VERSION ([0-9.]+)")));
    for (const auto& [program, path] : kPrograms) {
        const Ended ended = run_in_shell("'" + path + "' --version");
        EXPECT_EQ(ended.status, 0);
        EXPECT_EQ(run_in_shell("'" + path + "' -V").output, ended.output);
        const std::vector<std::string> lines = lines_of(ended.output);
        ASSERT_EQ(lines.size(), 2U) << ended.output;
        EXPECT_EQ(lines[0], program + " " + version[1].str());
        static const std::regex how(
            "built with [A-Za-z]+ [0-9.]+ for [^,]+ [a-z0-9_]+, [A-Za-z]+, "
            "(not )?hardened(, -fsanitize=[a-z,]+)*"
            "(, commit [0-9a-f]{12}( with changes)?)?");
        EXPECT_TRUE(std::regex_match(lines[1], how)) << lines[1];
    }
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

TEST(Help, KnowsEveryCommandAndOptionThatAPageNames) {
    static const std::regex call_form(
        R"((?:^|[\n$ /(])(tribus(?:-web|-mqtt)?) ([a-z]+)(?=[ \n])([^\n|;)]*))");
    static const std::regex option_form(R"((?:^| )(--[a-z][a-z0-9_-]*))");
    std::map<std::string, std::string> help;
    for (const auto& [program, path] : kPrograms) {
        for (const std::string& command : commands_of(path)) {
            help[program + " " + command] = whole_help_of(program, command);
        }
    }
    std::size_t found = 0;
    for (const auto& page : manual_pages()) {
        const std::string text = typed_text_in(page);
        for (std::sregex_iterator call(text.begin(), text.end(), call_form), none; call != none;
             ++call) {
            ++found;
            const auto known = help.find((*call)[1].str() + " " + (*call)[2].str());
            EXPECT_NE(known, help.end()) << page << ":" << call->str();
            const std::string words = (*call)[3];
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
