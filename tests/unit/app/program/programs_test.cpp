#include "app/program/tribus_program.h"

#include <functional>
#include <iterator>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "app/cli/command_line.h"
#include "app/cli/help_text.h"
#include "app/mqtt/mqtt_program.h"
#include "app/web/server/web_program.h"

/// The command lines of all programs: what their help shows, and whether its examples are right.
namespace tribus::programs_test {
namespace {

constexpr std::size_t kMostLines = 60;
constexpr std::size_t kMostColumns = 80;
constexpr BuildFacts kBuilt{.version = "1.2.3", .how = "a compiler", .commit = {}};

std::vector<Program> programs() {
    std::vector<Program> all;
    all.push_back(tribus_program());
    all.push_back(web::web_program("1.2.3"));
    all.push_back(mqtt::mqtt_program("1.2.3"));
    return all;
}

struct HelpPage {
    std::string of;
    std::string text;
};

/// Every text that `--help` prints, those of protocols too.
std::vector<HelpPage> help_pages() {
    std::vector<HelpPage> pages;
    for (const Program& program : programs()) {
        pages.push_back({program.name, help_of(program)});
        for (const Command& command : program.commands) {
            const std::string of = program.name + " " + command.name;
            pages.push_back({of, help_of(program, command)});
            for (const CommandOption& option : command.options) {
                if (!command.selected || option.name != command.selected->by) {
                    continue;
                }
                for (const std::string& value : option.offers()) {
                    if (command.selected->knows(value)) {
                        pages.push_back({of + " " + option.name + " " + value,
                                         help_of_selected(program, command, value)});
                    }
                }
            }
        }
    }
    return pages;
}

std::vector<std::string> lines_of(const std::string& text) {
    std::istringstream stream(text);
    std::vector<std::string> lines;
    for (std::string line; std::getline(stream, line);) {
        lines.push_back(line);
    }
    return lines;
}

TEST(HelpPages, AreOfAllProgramsCommandsAndProtocols) {
    EXPECT_GT(help_pages().size(), 3U + 20U + 3U + 1U + 35U);
}

TEST(HelpPages, HaveAtMost60LinesOf80Columns) {
    for (const HelpPage& page : help_pages()) {
        const std::vector<std::string> lines = lines_of(page.text);
        EXPECT_LE(lines.size(), kMostLines) << page.of;
        for (const std::string& line : lines) {
            EXPECT_LE(line.size(), kMostColumns) << page.of << ": " << line;
            EXPECT_FALSE(line.ends_with(' ')) << page.of << ": " << line;
        }
    }
}

TEST(HelpPages, BeginWithTheNameOfTheProgram) {
    for (const HelpPage& page : help_pages()) {
        EXPECT_TRUE(page.text.starts_with("Usage: " + page.of + " ")) << page.text;
    }
}

TEST(HelpPages, HaveNoWordsOfALibrary) {
    for (const HelpPage& page : help_pages()) {
        for (const char* word : {"TEXT", "INT", "FLOAT", "REQUIRED",
                                 "Excludes:", "Needs:", "OPTIONS] SUBCOMMAND", "Positionals"}) {
            for (const std::string& line : lines_of(page.text)) {
                const std::size_t at = line.find(word);
                const bool whole = at != line.npos && (at == 0 || !std::isalpha(line[at - 1])) &&
                                   !std::isalpha(line.c_str()[at + std::string(word).size()]);
                EXPECT_FALSE(whole) << page.of << ": " << line;
            }
        }
    }
}

TEST(HelpPages, HaveExamplesAndExitStatusesForCommands) {
    for (const Program& program : programs()) {
        for (const Command& command : program.commands) {
            const std::string help = help_of(program, command);
            EXPECT_NE(help.find("\nExamples:\n"), help.npos) << help;
            const std::size_t statuses = help.find("\nExit status:\n");
            ASSERT_NE(statuses, help.npos) << help;
            for (const char* status : {"\n  0  ", "\n  1  ", "\n  2  "}) {
                EXPECT_NE(help.find(status, statuses), help.npos) << help;
            }
        }
    }
}

TEST(HelpPages, NameTheValueOfEachOption) {
    const auto check = [](const std::string& of, const std::vector<CommandOption>& options) {
        for (const CommandOption& option : options) {
            EXPECT_EQ(value_text(option).empty(), option.flag()) << of << " " << option.name;
        }
    };
    for (const Program& program : programs()) {
        for (const Command& command : program.commands) {
            check(program.name + " " + command.name, command.options);
            if (command.selected) {
                check(program.name + " " + command.name, command.selected->of(""));
            }
        }
    }
}

/// A command line of an example, as a shell breaks it, but without quotes.
struct Call {
    std::string example;
    std::vector<std::string> words;
};

/// The calls of programs of this project in an example; other programs are left out.
std::vector<Call> calls_in(std::string_view example) {
    std::vector<Call> calls;
    std::istringstream parts{std::string(example)};
    for (std::string part; std::getline(parts, part, '|');) {
        std::istringstream stream(part.substr(0, part.find('>')));
        std::vector<std::string> words{std::istream_iterator<std::string>(stream), {}};
        if (!words.empty() && words.front() == "sudo") {
            words.erase(words.begin());
        }
        if (!words.empty() && words.front().starts_with("tribus")) {
            calls.push_back({std::string(example), words});
        }
    }
    return calls;
}

std::vector<Call> calls_of_examples() {
    std::vector<Call> calls;
    const auto add = [&calls](const std::vector<CommandExample>& examples) {
        for (const CommandExample& example : examples) {
            std::ranges::move(calls_in(example.line), std::back_inserter(calls));
        }
    };
    for (const Program& program : programs()) {
        add(program.examples);
        for (const Command& command : program.commands) {
            add(command.examples);
        }
    }
    return calls;
}

/// Whether the program of that name takes the words. Nothing is run.
bool takes(const std::vector<std::string>& words) {
    std::vector<const char*> pointers;
    for (const std::string& word : words) {
        pointers.push_back(word.c_str());
    }
    for (Program& program : programs()) {
        if (program.name == words.front()) {
            return read_command_line(program, kBuilt, static_cast<int>(pointers.size()),
                                     pointers.data())
                .has_value();
        }
    }
    return false;
}

TEST(ExamplesOfHelp, AreCommandLinesThatTheProgramTakes) {
    const std::vector<Call> calls = calls_of_examples();
    EXPECT_GE(calls.size(), 45U);
    for (const Call& call : calls) {
        EXPECT_TRUE(takes(call.words)) << call.example;
    }
    testing::internal::CaptureStderr();
    EXPECT_FALSE(takes({"tribus", "check", "--fromat", "json", "servos.toml"}));
    EXPECT_FALSE(takes({"tribus", "replay", "receiver.txt"}));
    testing::internal::GetCapturedStderr();
}

TEST(ExamplesOfHelp, BelongToTheirCommand) {
    for (const Program& program : programs()) {
        for (const Command& command : program.commands) {
            bool found = false;
            for (const CommandExample& example : command.examples) {
                const std::string call = program.name + " " + command.name;
                found = found || example.line.find(call) != example.line.npos;
            }
            EXPECT_TRUE(found) << program.name << " " << command.name;
        }
    }
}

}  // namespace
}  // namespace tribus::programs_test
