#include <algorithm>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/shell.h"

/// Compares the installed files with what the program itself prints.
namespace tribus::test::installed_texts_test {
namespace {

using Words = std::vector<std::string>;

Words words_of(const std::string& text) {
    std::istringstream stream(text);
    Words words;
    for (std::string word; stream >> word;) {
        words.push_back(word);
    }
    return words;
}

bool has(const Words& words, const std::string& word) {
    return std::ranges::find(words, word) != words.end();
}

/// Returns what bash offers for the last word of a command line.
Words offered(const std::string& line) {
    const Ended ended = run_in_shell("export TRIBUS; bash -c '. " TRIBUS_SOURCE_DIR
                                     "/deploy/completions/tribus.bash; COMP_WORDS=(\"$TRIBUS\" " +
                                     line +
                                     "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _tribus; "
                                     "echo \"${COMPREPLY[@]}\"'");
    EXPECT_EQ(ended.status, 0) << ended.output;
    return words_of(ended.output);
}

Words commands() {
    const Ended help = run_in_shell("\"$TRIBUS\" --help");
    std::istringstream lines(help.output.substr(help.output.find("Subcommands:")));
    Words names;
    for (std::string line; std::getline(lines, line);) {
        if (line.starts_with("  ") && line[2] != ' ') {
            names.push_back(words_of(line).front());
        }
    }
    return names;
}

TEST(BashCompletion, offers_every_command) {
    ASSERT_GE(commands().size(), 10U);
    const Words all = offered("\"\"");
    for (const std::string& command : commands()) {
        EXPECT_TRUE(has(all, command)) << command;
    }
}

TEST(BashCompletion, offers_the_commands_that_begin_so) {
    EXPECT_EQ(offered("ch"), Words{"check"});
}

TEST(BashCompletion, offers_the_options_of_the_command) {
    EXPECT_EQ(offered("simulate --t"), Words{"--tail"});
    EXPECT_EQ(offered("check --f"), Words{"--format"});
}

TEST(BashCompletion, offers_the_choices_of_an_option) {
    EXPECT_EQ(offered("check --format \"\""), (Words{"toml", "json"}));
}

TEST(BashCompletion, offers_the_protocols) {
    const Words all = offered("decode --protocol \"\"");
    for (const char* protocol : {"auto", "ibus", "sbus", "can", "dronecan", "ibus-sensor"}) {
        EXPECT_TRUE(has(all, protocol)) << protocol;
    }
    EXPECT_EQ(offered("encode --protocol i"), Words{"ibus"});
}

TEST(BashCompletion, offers_the_choices_of_a_setting) {
    EXPECT_EQ(offered("decode --slots \"\""), (Words{"nibbles", "plain"}));
    EXPECT_EQ(offered("encode --reversible t"), Words{"true"});
}

TEST(BashCompletion, offers_files) {
    EXPECT_EQ(offered("check " TRIBUS_SOURCE_DIR "/config/examples/main-j"),
              Words{TRIBUS_SOURCE_DIR "/config/examples/main-job.toml"});
}

TEST(ManualPage, has_every_command) {
    for (const std::string& command : commands()) {
        const Ended found = run_in_shell("grep -x '.It Cm " + command +
                                         "' " TRIBUS_SOURCE_DIR "/deploy/man/tribus.1");
        EXPECT_EQ(found.status, 0) << command;
    }
}

TEST(ManualPage, of_the_configuration_has_every_table) {
    const Ended missing = run_in_shell(
        "\"$TRIBUS\" schema | python3 -c 'import json, sys\n"
        "page = open(\"" TRIBUS_SOURCE_DIR
        "/deploy/man/tribus.toml.5\").read()\n"
        "for key in json.load(sys.stdin)[\"properties\"]:\n"
        "    if \"[\" + key not in page: print(key)'");
    EXPECT_EQ(missing.output, "");
}

}  // namespace
}  // namespace tribus::test::installed_texts_test
