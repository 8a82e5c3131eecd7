#include <algorithm>
#include <filesystem>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/pages.h"
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

/// What the manual page says of a command.
std::string section_of(const std::string& page, const std::string& command) {
    const std::string title = "\n.Ss " + command + "\n";
    const std::size_t begin = page.find(title);
    if (begin == std::string::npos) {
        return "";
    }
    const std::size_t end =
        std::min(page.find("\n.Ss ", begin + title.size()), page.find("\n.Sh ", begin));
    return page.substr(begin, end - begin);
}

/// Its options, `--help` aside.
Words options_of(const std::string& command, const std::string& program = "\"$TRIBUS\"") {
    static const std::regex form(R"(\n +(?:-[a-zA-Z],)?--([a-z0-9_-]+))");
    const std::string help = run_in_shell(program + " " + command + " --help").output;
    Words options;
    for (std::sregex_iterator match(help.begin(), help.end(), form), none; match != none; ++match) {
        if ((*match)[1] != "help") {
            options.push_back((*match)[1]);
        }
    }
    return options;
}

const std::string kManualPage =
    text_of_file(std::filesystem::path(TRIBUS_SOURCE_DIR) / "deploy" / "man" / "tribus.1");

TEST(ManualPage, has_every_command) {
    for (const std::string& command : commands()) {
        EXPECT_NE(section_of(kManualPage, command), "") << command;
    }
}

TEST(ManualPage, has_every_option_of_a_command_in_its_section) {
    std::size_t count = 0;
    for (const std::string& command : commands()) {
        const Words words = words_of(section_of(kManualPage, command));
        for (const std::string& option : options_of(command)) {
            EXPECT_TRUE(has(words, "-" + option)) << command << " --" << option;
            ++count;
        }
    }
    EXPECT_GT(count, 80U);
}

TEST(ManualPage, has_no_option_that_the_command_does_not_know) {
    static const std::regex item("\n\\.It ([^\n]*)");
    static const std::regex flag("Fl -([a-z0-9_-]+)");
    for (const std::string& command : commands()) {
        const Words known = options_of(command);
        const std::string section = section_of(kManualPage, command);
        for (std::sregex_iterator line(section.begin(), section.end(), item), none; line != none;
             ++line) {
            const std::string text = (*line)[1];
            for (std::sregex_iterator match(text.begin(), text.end(), flag); match != none;
                 ++match) {
                EXPECT_TRUE(has(known, (*match)[1])) << command << " --" << (*match)[1];
            }
        }
    }
}

/// The options that the manual page of a further program has.
Words described_in(const std::string& name) {
    const std::string page =
        text_of_file(std::filesystem::path(TRIBUS_SOURCE_DIR) / "deploy" / "man" / name);
    static const std::regex item("\n\\.It Fl -([a-z0-9_-]+)");
    Words described;
    for (std::sregex_iterator match(page.begin(), page.end(), item), none; match != none; ++match) {
        described.push_back((*match)[1]);
    }
    return described;
}

TEST(ManualPage, of_the_page_has_its_options_and_no_others) {
    EXPECT_EQ(described_in("tribus-web.8"), options_of("serve", "'" TRIBUS_WEB "'"));
}

TEST(ManualPage, of_the_mqtt_bridge_has_its_options_and_no_others) {
    EXPECT_EQ(described_in("tribus-mqtt.8"), options_of("run", "'" TRIBUS_MQTT "'"));
}

TEST(ManualPage, is_set_without_a_warning) {
    if (run_in_shell("groff --version").status != 0) {
        GTEST_SKIP() << "needs groff";
    }
    for (const char* page : {"cat '" TRIBUS_SOURCE_DIR "/deploy/man/tribus.1'",
                             "cat '" TRIBUS_SOURCE_DIR "/deploy/man/tribus-web.8'",
                             "cat '" TRIBUS_SOURCE_DIR "/deploy/man/tribus-mqtt.8'",
                             "'" TRIBUS_PROGRAM "' schema --format man"}) {
        const Ended set = run_in_shell(std::string(page) + " | groff -mdoc -ww -z -Tutf8");
        EXPECT_EQ(set.output, "") << page;
        EXPECT_EQ(set.status, 0) << page;
    }
}

}  // namespace
}  // namespace tribus::test::installed_texts_test
