#include <algorithm>
#include <filesystem>
#include <regex>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/pages.h"
#include "tests/support/program_help.h"
#include "tests/support/shell.h"
#include "tests/support/temporary_folder.h"

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

/// Returns what bash offers for the last word of a command line, whose words are as readline breaks
/// them. `before`: what the shell does before.
Words offered(const std::string& line, const std::string& program = TRIBUS_PROGRAM,
              const std::string& before = "") {
    const Ended ended = run_in_shell(
        before +
        " bash -c '. " TRIBUS_SOURCE_DIR "/deploy/completions/tribus.bash; COMP_WORDS=(\"" +
        program + "\" " + line +
        "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _tribus; echo \"${COMPREPLY[@]}\"'");
    EXPECT_EQ(ended.status, 0) << ended.output;
    return words_of(ended.output);
}

TEST(BashCompletion, OffersEveryCommand) {
    ASSERT_GE(commands_of(TRIBUS_PROGRAM).size(), 10U);
    const Words all = offered("\"\"");
    for (const std::string& command : commands_of(TRIBUS_PROGRAM)) {
        EXPECT_TRUE(has(all, command)) << command;
    }
}

TEST(BashCompletion, OffersTheCommandsAndOptionsOfTheProgramsBeside) {
    for (const std::string program : {TRIBUS_WEB, TRIBUS_MQTT}) {
        EXPECT_FALSE(commands_of(program).empty());
        EXPECT_EQ(offered("\"\"", program), commands_of(program));
    }
    EXPECT_EQ(offered("serve --li", TRIBUS_WEB), Words{"--listen"});
    EXPECT_EQ(offered("run --br", TRIBUS_MQTT), Words{"--broker"});
}

TEST(BashCompletion, OffersChoicesBehindTheEqualsSign) {
    EXPECT_EQ(offered("check --format = \"\""), (Words{"toml", "json"}));
    EXPECT_EQ(offered("check --format ="), (Words{"toml", "json"}));
    EXPECT_EQ(offered("check --format = j"), Words{"json"});
    EXPECT_EQ(offered("decode --protocol = sbus --sc"), Words{"--scale"});
    // COMP_WORDBREAKS without "=": the whole word is replaced.
    EXPECT_EQ(offered("check --format=j"), Words{"--format=json"});
}

TEST(BashCompletion, OffersTheSettingsOfTheProtocol) {
    EXPECT_EQ(offered("decode --protocol sbus --scale p"), Words{"px4"});
    EXPECT_EQ(offered("decode --protocol dsm --scale \"\""), (Words{"spektrum", "betaflight"}));
    EXPECT_FALSE(has(offered("decode --protocol ibus --scale \"\""), "betaflight"));
}

TEST(BashCompletion, OffersTheNamesOfRunningDaemons) {
    const TemporaryFolder folder;
    const std::string place = folder.path().string();
    folder.write("boat.toml",
                 "[input.receiver]\nprotocol = \"ibus\"\ndevice = \"" + place +
                     "/receiver\"\n[output.servos]\nprotocol = \"sbus\"\ndevice = \"" + place +
                     "/servos\"\n[pipeline.main]\nfrom = \"receiver\"\nto = \"servos\"\n");
    const std::string here = "export XDG_RUNTIME_DIR='" + place + "';";
    const std::string daemon = here + "cd '" + place +
                               "'; mkdir tribus; '" TRIBUS_PROGRAM
                               "' run --socket tribus/boat.sock boat.toml >/dev/null 2>&1 & "
                               "daemon=$!; trap 'kill $daemon; wait $daemon' EXIT; "
                               "for i in $(seq 300); do [ -S tribus/boat.sock ] && break; "
                               "sleep 0.1; done; ";
    for (const std::string line : {"monitor bo", "status bo", "reload bo", "record bo",
                                   "diff new.toml --daemon bo", "diff --daemon = bo"}) {
        EXPECT_TRUE(has(offered(line, TRIBUS_PROGRAM, daemon), "boat")) << line;
    }
    EXPECT_EQ(offered("monitor bo", TRIBUS_PROGRAM, here), Words{});
}

/// Completion must not take longer than a program takes to start: it starts the program once, and
/// nothing else.
TEST(BashCompletion, StartsTheProgramOnceAndNothingElse) {
    const TemporaryFolder folder;
    const std::string log = (folder.path() / "log").string();
    const std::string program = folder.write(
        "tribus", "#!/bin/sh\necho \"$@\" >>'" + log + "'\nexec '" TRIBUS_PROGRAM "' \"$@\"\n");
    std::filesystem::permissions(program, std::filesystem::perms::all);
    const std::string nothing = "export PATH=/nonexistent; bash() { /bin/bash \"$@\"; };";
    EXPECT_EQ(offered("decode --protocol ib", program, nothing),
              (Words{"ibus", "ibus2", "ibus-sensor"}));
    EXPECT_EQ(text_of_file(log), "--complete decode --protocol ib\n");
    EXPECT_TRUE(has(offered("check " TRIBUS_SOURCE_DIR "/config/examples/main-j", program, nothing),
                    TRIBUS_SOURCE_DIR "/config/examples/main-job.toml"));
    EXPECT_EQ(words_of(text_of_file(log)).size(), 7U) << text_of_file(log);
}

TEST(BashCompletion, IsThatOfAllPrograms) {
    const Ended ended =
        run_in_shell("bash -c '. " TRIBUS_SOURCE_DIR
                     "/deploy/completions/tribus.bash; complete -p tribus tribus-web "
                     "tribus-mqtt'");
    EXPECT_EQ(ended.output,
              "complete -F _tribus tribus\ncomplete -F _tribus tribus-web\n"
              "complete -F _tribus tribus-mqtt\n");
}

/// What fish offers for a command line of the program, which is found by its name.
Words offered_by_fish(const std::string& line) {
    const Ended ended =
        run_in_shell("export HOME=/nonexistent; cd '" +
                     std::filesystem::path(TRIBUS_PROGRAM).parent_path().string() +
                     "'; PATH=\"$PWD:$PATH\" fish --no-config -c 'source " TRIBUS_SOURCE_DIR
                     "/deploy/completions/tribus.fish; complete -C \"" +
                     line + "\"' | cut -f 1");
    return words_of(ended.output);
}

TEST(FishCompletion, OffersCommandsOptionsAndChoices) {
    if (run_in_shell("fish --version").status != 0) {
        GTEST_SKIP() << "needs fish";
    }
    EXPECT_EQ(offered_by_fish("tribus chec"), Words{"check"});
    EXPECT_EQ(offered_by_fish("tribus check --form"), Words{"--format"});
    EXPECT_EQ(offered_by_fish("tribus check --format j"), Words{"json"});
    EXPECT_EQ(offered_by_fish("tribus check --format=j"), Words{"--format=json"});
    EXPECT_EQ(offered_by_fish("tribus-web serv"), Words{"serve"});
    EXPECT_EQ(offered_by_fish("tribus-mqtt run --brok"), Words{"--broker"});
}

/// What zsh is given to offer for the last of some words; FILES stands for the names of files.
Words offered_by_zsh(const std::string& line) {
    const Ended ended = run_in_shell(
        "zsh -fc 'offer() { local -a words=(" TRIBUS_PROGRAM " " + line +
        "); local CURRENT=${#words} PREFIX=${words[-1]}; . " TRIBUS_SOURCE_DIR
        "/deploy/completions/_tribus; }; _describe() { print -rl -- ${${(P)4}%%:*}; }; "
        "compset() { :; }; _files() { print FILES; }; offer'");
    EXPECT_EQ(ended.status, 0) << ended.output;
    return words_of(ended.output);
}

TEST(ZshCompletion, OffersCommandsOptionsChoicesAndFiles) {
    if (run_in_shell("zsh --version").status != 0) {
        GTEST_SKIP() << "needs zsh";
    }
    EXPECT_EQ(offered_by_zsh("chec"), Words{"check"});
    EXPECT_EQ(offered_by_zsh("check --form"), Words{"--format"});
    EXPECT_EQ(offered_by_zsh("check --format \"\""), (Words{"toml", "json"}));
    EXPECT_EQ(offered_by_zsh("check --format=j"), Words{"json"});
    EXPECT_EQ(offered_by_zsh("check x"), Words{"FILES"});
}

TEST(BashCompletion, OffersTheCommandsThatBeginSo) {
    EXPECT_EQ(offered("ch"), Words{"check"});
}

TEST(BashCompletion, OffersTheOptionsOfTheCommand) {
    EXPECT_EQ(offered("simulate --t"), Words{"--tail"});
    EXPECT_EQ(offered("check --f"), Words{"--format"});
}

TEST(BashCompletion, OffersTheChoicesOfAnOption) {
    EXPECT_EQ(offered("check --format \"\""), (Words{"toml", "json"}));
}

TEST(BashCompletion, OffersTheProtocols) {
    const Words all = offered("decode --protocol \"\"");
    for (const char* protocol : {"auto", "ibus", "sbus", "can", "dronecan", "ibus-sensor"}) {
        EXPECT_TRUE(has(all, protocol)) << protocol;
    }
    EXPECT_EQ(offered("encode --protocol i"), Words{"ibus"});
    EXPECT_TRUE(has(offered("record --protocol f"), "fport"));
}

TEST(BashCompletion, OffersTheChoicesOfASetting) {
    EXPECT_EQ(offered("decode --slots \"\""), (Words{"nibbles", "plain"}));
    EXPECT_EQ(offered("encode --carries m"), Words{"motors"});
}

TEST(BashCompletion, OffersFiles) {
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

/// The protocols whose settings are options of a command; none if it has no such options.
Words protocols_of(const std::string& command) {
    return command == "decode" || command == "encode" ? offered(command + " --protocol \"\"")
                                                      : Words{};
}

/// Its options with those of each protocol, `--help` aside.
Words options_of(const std::string& command, const std::string& program = TRIBUS_PROGRAM) {
    static const std::regex form(R"(\n  (?:-[a-zA-Z], )?--([a-z0-9_-]+))");
    std::string help = run_in_shell("'" + program + "' " + command + " --help").output;
    for (const std::string& protocol : protocols_of(command)) {
        help += run_in_shell("'" + program + "' " + command + " --protocol " + protocol + " --help")
                    .output;
    }
    Words options;
    for (std::sregex_iterator match(help.begin(), help.end(), form), none; match != none; ++match) {
        if ((*match)[1] != "help" && !has(options, (*match)[1])) {
            options.push_back((*match)[1]);
        }
    }
    return options;
}

const std::string kManualPage =
    text_of_file(std::filesystem::path(TRIBUS_SOURCE_DIR) / "deploy" / "man" / "tribus.1");

TEST(ManualPage, HasEveryCommand) {
    for (const std::string& command : commands_of(TRIBUS_PROGRAM)) {
        EXPECT_NE(section_of(kManualPage, command), "") << command;
    }
}

TEST(ManualPage, HasEveryOptionOfACommandInItsSection) {
    std::size_t count = 0;
    for (const std::string& command : commands_of(TRIBUS_PROGRAM)) {
        const Words words = words_of(section_of(kManualPage, command));
        for (const std::string& option : options_of(command)) {
            EXPECT_TRUE(has(words, "-" + option)) << command << " --" << option;
            ++count;
        }
    }
    EXPECT_GT(count, 80U);
}

TEST(ManualPage, HasNoOptionThatTheCommandDoesNotKnow) {
    static const std::regex item("\n\\.It ([^\n]*)");
    static const std::regex flag("Fl -([a-z0-9_-]+)");
    for (const std::string& command : commands_of(TRIBUS_PROGRAM)) {
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

TEST(ManualPage, HasTheOptionsOfThePageAndNoOthers) {
    EXPECT_EQ(described_in("tribus-web.8"), options_of("serve", TRIBUS_WEB));
}

TEST(ManualPage, HasTheOptionsOfTheMqttBridgeAndNoOthers) {
    EXPECT_EQ(described_in("tribus-mqtt.8"), options_of("run", TRIBUS_MQTT));
}

TEST(ManualPage, HasTheCommandsAndExitStatusesOfTheProgramsBeside) {
    for (const auto& [name, program] :
         {std::pair{"tribus-web.8", TRIBUS_WEB}, std::pair{"tribus-mqtt.8", TRIBUS_MQTT}}) {
        const std::string page =
            text_of_file(std::filesystem::path(TRIBUS_SOURCE_DIR) / "deploy" / "man" / name);
        for (const std::string& command : commands_of(program)) {
            EXPECT_NE(page.find("\n.Cm " + command + "\n"), page.npos) << name << " " << command;
            for (const std::string& option : options_of(command, program)) {
                EXPECT_NE(page.find("Fl -" + option), page.npos) << name << " --" << option;
            }
        }
        for (const char* section :
             {"\n.Sh EXIT STATUS\n", "\n.Sh EXAMPLES\n", "\n.Fl V | -version\n"}) {
            EXPECT_NE(page.find(section), page.npos) << name << " has no " << section;
        }
    }
}

TEST(ManualPage, IsSetWithoutAWarning) {
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
