#include "app/cli/command_line.h"

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "app/cli/help_text.h"
#include "app/cli/wrong_use.h"

namespace tribus::command_line_test {
namespace {

constexpr BuildFacts kBuilt{.version = "1.2.3", .how = "GCC 12 for Debian", .commit = "0123abc"};

/// What the options of a program for a test are set to.
struct Given {
    std::string file;
    std::string format = "text";
    std::optional<double> seconds;
    std::optional<std::int64_t> number;
    std::vector<std::string> in;
    bool once = false;
    std::string setting;
};

/// A program `boat` with a command that has every kind of option.
Program boat(Given& given) {
    return {
        .name = "boat",
        .help = "Steer",
        .commands = {
            {.name = "steer",
             .help = "Steer the boat",
             .notes = "Words of the table:\n  port       left\n  starboard  right",
             .options = {{.name = "FILE", .value = &given.file, .help = "Course", .required = true},
                         {.name = "--format",
                          .value = &given.format,
                          .help = "Form",
                          .shows_value = true,
                          .choices = {"text", "json"}},
                         {.name = "--seconds",
                          .value = &given.seconds,
                          .help = "How long",
                          .range = {{0.5, 60}},
                          .value_name = "SECONDS",
                          .excludes = {"--once"}},
                         {.name = "--number",
                          .value = &given.number,
                          .help = "Which",
                          .value_name = "NUMBER",
                          .needs = {"--once"}},
                         {.name = "--in",
                          .value = &given.in,
                          .help = "From where",
                          .value_name = "PLACE",
                          .one_each = true},
                         {.name = "--once", .value = &given.once, .help = "Once"}},
             .examples = {{"boat steer course.txt", "along the course"}},
             .exits = {{1, "aground"}},
             .selected = SelectedOptions{
                 .by = "--format",
                 .of =
                     [&given](std::string_view) {
                         return std::vector<CommandOption>{{.name = "--indent",
                                                            .value = &given.setting,
                                                            .help = "How deep",
                                                            .value_name = "NUMBER"}};
                     },
                 .knows = [](std::string_view value) { return value == "json"; }},
             .run = [] { return 7; }},
            {.name = "anchor", .help = "Stop", .run = [] { return 8; }}}};
}

struct Outcome {
    /// What the run returns, or the status without a run.
    int status = -1;
    bool runs = false;
    std::string output;
    std::string errors;
};

Outcome read(Given& given, std::vector<const char*> words) {
    words.insert(words.begin(), "boat");
    Program program = boat(given);
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    const auto run =
        read_command_line(program, kBuilt, static_cast<int>(words.size()), words.data());
    return {run ? (*run)() : run.error(), run.has_value(), testing::internal::GetCapturedStdout(),
            testing::internal::GetCapturedStderr()};
}

Outcome read(std::vector<const char*> words) {
    Given given;
    return read(given, std::move(words));
}

TEST(CommandLine, SetsTheOptionsAndNamesTheRun) {
    Given given;
    const Outcome outcome = read(given, {"steer", "--format=json", "--in", "a", "--in=b", "c.txt",
                                         "--number", "0x10", "--once", "--indent", "2"});
    EXPECT_TRUE(outcome.runs) << outcome.errors;
    EXPECT_EQ(outcome.status, 7);
    EXPECT_EQ(given.file, "c.txt");
    EXPECT_EQ(given.format, "json");
    EXPECT_EQ(given.in, (std::vector<std::string>{"a", "b"}));
    EXPECT_EQ(given.number, 16);
    EXPECT_TRUE(given.once);
    EXPECT_EQ(given.setting, "2");
}

struct WrongUse {
    std::vector<const char*> words;
    std::string message;
};

class CommandLineMistake : public testing::TestWithParam<WrongUse> {};

TEST_P(CommandLineMistake, IsToldInOneLineWithWhatIsAllowed) {
    const Outcome outcome = read(GetParam().words);
    EXPECT_FALSE(outcome.runs);
    EXPECT_EQ(outcome.status, 2);
    EXPECT_EQ(outcome.output, "");
    EXPECT_EQ(outcome.errors, "boat: " + GetParam().message + "\n");
}

INSTANTIATE_TEST_SUITE_P(
    Each, CommandLineMistake,
    testing::Values(
        WrongUse{{"stear"},
                 R"("stear" is not a command; did you mean "steer"? Allowed: "steer", "anchor")"},
        WrongUse{{"--vresion"},
                 "--vresion is not an option of boat; did you mean --version? `boat --help` lists "
                 "them"},
        WrongUse{{"steer", "--fromat", "json", "c.txt"},
                 "--fromat is not an option of boat steer; did you mean --format? `boat steer "
                 "--help` lists them"},
        WrongUse{{"steer", "--fromat=json"},
                 "--fromat is not an option of boat steer; did you mean --format? `boat steer "
                 "--help` lists them"},
        WrongUse{{"steer", "--indnet", "2", "c.txt"},
                 "--indnet is not an option of boat steer; did you mean --indent? `boat steer "
                 "--help` lists them"},
        WrongUse{{"steer", "-x", "c.txt"},
                 "-x is not an option of boat steer; `boat steer --help` lists them"},
        WrongUse{{"steer", "--format", "jsn", "c.txt"},
                 R"(--format: "jsn" is not known; did you mean "json"? Allowed: "text", "json")"},
        WrongUse{{"steer", "--seconds", "soon", "c.txt"},
                 R"(--seconds: "soon" is not possible; allowed: a number from 0.5 to 60)"},
        WrongUse{{"steer", "--seconds", "0.1", "c.txt"},
                 R"(--seconds: "0.1" is not possible; allowed: a number from 0.5 to 60)"},
        WrongUse{{"steer", "--seconds", "61", "c.txt"},
                 R"(--seconds: "61" is not possible; allowed: a number from 0.5 to 60)"},
        WrongUse{{"steer", "--once", "--number", "1.5", "c.txt"},
                 R"(--number: "1.5" is not possible; allowed: a whole number)"},
        WrongUse{{"steer"}, "FILE is missing; usage: boat steer [OPTIONS] FILE"},
        WrongUse{{"steer", "c.txt", "d.txt"},
                 R"("d.txt" is one word too many; usage: boat steer [OPTIONS] FILE)"},
        WrongUse{{"steer", "c.txt", "--format"}, "--format needs a value: text|json"},
        WrongUse{{"steer", "c.txt", "--format", "text", "--format", "json"},
                 "--format is given several times; allowed: once"},
        WrongUse{{"steer", "c.txt", "--number", "1"}, "--number requires --once"},
        WrongUse{{"steer", "c.txt", "--once", "--seconds", "1"},
                 "--seconds and --once do not go together"}));

TEST(CommandLine, WithoutWordsShowsTheHelpAsAMistake) {
    Given given;
    const Outcome outcome = read({});
    EXPECT_EQ(outcome.status, 2);
    EXPECT_EQ(outcome.errors, help_of(boat(given)));
}

TEST(CommandLine, ShowsTheVersionAndHowItWasBuilt) {
    for (const char* option : {"-V", "--version"}) {
        const Outcome outcome = read({option});
        EXPECT_EQ(outcome.status, 0);
        EXPECT_EQ(outcome.output, "boat 1.2.3\nbuilt with GCC 12 for Debian, commit 0123abc\n");
    }
}

TEST(CommandLine, ShowsNoCommitThatIsNotKnown) {
    EXPECT_EQ(version_text("boat", {.version = "1", .how = "GCC", .commit = {}}),
              "boat 1\nbuilt with GCC\n");
}

TEST(CommandLine, ShowsTheHelpOfTheCommandWhateverElseIsMissing) {
    Given given;
    const Program program = boat(given);
    EXPECT_EQ(read({"--help"}).output, help_of(program));
    EXPECT_EQ(read({"-h"}).output, help_of(program));
    EXPECT_EQ(read({"steer", "--help"}).output, help_of(program, program.commands.front()));
}

TEST(CommandLine, ShowsTheOptionsThatAnotherOptionSelects) {
    Given given;
    const Program program = boat(given);
    const std::string selected = help_of_selected(program, program.commands.front(), "json");
    EXPECT_EQ(read({"steer", "--format", "json", "--help"}).output, selected);
    EXPECT_EQ(read({"steer", "--help", "--format=json"}).output, selected);
    EXPECT_EQ(read({"steer", "--help", "--format=text"}).output,
              help_of(program, program.commands.front()));
    EXPECT_EQ(selected,
              "Usage: boat steer --format json [OPTIONS] FILE\n\n"
              "Options of json:\n"
              "  --indent NUMBER  How deep\n\n"
              "`boat steer --help` shows the other options and examples.\n");
}

TEST(HelpText, NamesValuesDefaultsLimitsAndWhatGoesTogether) {
    Given given;
    const Program program = boat(given);
    EXPECT_EQ(help_of(program, program.commands.front()),
              "Usage: boat steer [OPTIONS] FILE\n"
              "\n"
              "Steer the boat.\n"
              "\n"
              "Arguments:\n"
              "  FILE  Course\n"
              "\n"
              "Options:\n"
              "  --format text|json  Form; default: text\n"
              "  --seconds SECONDS   How long; 0.5 to 60; not with --once\n"
              "  --number NUMBER     Which; only with --once\n"
              "  --in PLACE          From where; may be repeated\n"
              "  --once              Once\n"
              "  -h, --help          Show this help\n"
              "\n"
              "Words of the table:\n"
              "  port       left\n"
              "  starboard  right\n"
              "\n"
              "Examples:\n"
              "  boat steer course.txt\n"
              "      along the course\n"
              "\n"
              "Exit status:\n"
              "  0  fine\n"
              "  1  aground\n"
              "  2  wrong use, or a configuration with mistakes\n");
}

TEST(HelpText, ListsTheCommandsOfAProgram) {
    Given given;
    const std::string help = help_of(boat(given));
    EXPECT_TRUE(
        help.starts_with("Usage: boat COMMAND [OPTIONS] [ARGUMENTS]\n\nSteer.\n\n"
                         "Commands:\n  steer   Steer the boat\n  anchor  Stop\n"))
        << help;
    EXPECT_NE(help.find("\n  -V, --version  "), std::string::npos) << help;
}

TEST(HelpText, GoesOnUnderTheTextOfAnOption) {
    Given given;
    Program program = boat(given);
    program.commands.front().options[1].help = std::string(30, 'a') + " " + std::string(30, 'b');
    EXPECT_NE(help_of(program, program.commands.front())
                  .find("  --format text|json  " + std::string(30, 'a') + "\n" +
                        std::string(22, ' ') + std::string(30, 'b') + ";"),
              std::string::npos)
        << help_of(program, program.commands.front());
}

}  // namespace
}  // namespace tribus::command_line_test
