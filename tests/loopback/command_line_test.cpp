#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/loopback/loopback.h"

namespace tribus::test::command_line_test {
namespace {

using Words = std::vector<std::string>;

std::vector<std::string> lines_of(const std::string& text) {
    std::vector<std::string> lines;
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);) {
        lines.push_back(line);
    }
    return lines;
}

TEST_F(Loopback, MissingDevicesAreEachNamedWithTheirPlaceInTheFile) {
    const std::string path = write_config(main_job());
    Program& program = run(path);
    const std::string errors = program.errors();
    const std::string place = path + ":3:10: " + folder().string() + "/receiver: ";
    EXPECT_EQ(count_of(place + "there is no such device", errors), 1U) << errors;
    const std::string second = path + ":7:10: " + folder().string() + "/servos: ";
    EXPECT_EQ(count_of(second + "there is no such device", errors), 1U) << errors;
    EXPECT_EQ(count_of("waiting for it", errors), 2U) << errors;
    EXPECT_EQ(program.output(), "");
    expect_clean_end(program);
}

TEST_F(Loopback, DeviceThatIsNoSerialOneIsRefused) {
    device("servos");
    std::string text = main_job();
    text.replace(text.find("@receiver"), 9, "/dev/null");
    Program& program = start({"run", write_config(text)});
    EXPECT_EQ(program.end(), 2);
    EXPECT_EQ(count_of("\"/dev/null\": this is not a serial device", program.errors()), 1U)
        << program.errors();
}

TEST_F(Loopback, SecondRunOnADeviceIsRefusedAndTheFirstGoesOn) {
    FarEnd& receiver = device("receiver");
    FarEnd& servo_wire = device("servos");
    const std::string path = write_config(main_job(kPatientInput));
    Program& first = run(path);
    Program& second = start({"run", path});
    EXPECT_EQ(second.end(), 1);
    EXPECT_EQ(count_of("another program uses it", second.errors()), 2U) << second.errors();
    Repeater repeater(receiver, ibus_bytes(sticks_with_first(1234)));
    ServoBank servos(servo_wire);
    EXPECT_TRUE(eventually([&] {
        repeater.send_if_due();
        const auto seen = servos.listen();
        return !seen.empty() && seen.back().good() && seen.back().raw[0] == sbus_raw(1234);
    }));
    expect_clean_end(first);
}

TEST_F(Loopback, OneDeviceUnderTwoNamesIsRefused) {
    FarEnd& port = device("receiver");
    std::filesystem::create_symlink(port.path(), folder() / "servos");
    Program& program = start({"run", write_config(main_job())});
    EXPECT_EQ(program.end(), 1);
    EXPECT_EQ(count_of("this one opened it under another name", program.errors()), 1U)
        << program.errors();
}

TEST_F(Loopback, CheckWarnsOfAMapThatReadsAChannelWhichTheInputMayNotHave) {
    Program& check =
        start({"check", write_config(main_job("", "", "[pipeline.main.channels]\n3 = 17"))});
    EXPECT_EQ(check.end(), 0) << check.errors();
    EXPECT_NE(check.errors().find(": warning: channel 3 is made from channel 17, which input "
                                  "\"receiver\" (ibus) may lack; "),
              std::string::npos)
        << check.errors();
    EXPECT_NE(check.output().find("[pipeline.main.channels]"), std::string::npos);
}

TEST_F(Loopback, CheckPrintsMistakesAsJsonToo) {
    const std::string path =
        std::string(TRIBUS_SOURCE_DIR) + "/tests/unit/config/ten_mistakes.toml";
    Program& check = start({"check", path, "--format", "json"});
    EXPECT_EQ(check.end(), 2);
    const auto mistakes = nlohmann::json::parse(check.output())["mistakes"];
    ASSERT_EQ(mistakes.size(), 10U);
    EXPECT_EQ(mistakes[0]["file"], path);
    EXPECT_EQ(mistakes[0]["line"], 2);
    EXPECT_EQ(mistakes[0]["column"], 12);
    EXPECT_EQ(mistakes[0]["text"], "\"priority\" is 100; allowed: a whole number from 1 to 99");
    EXPECT_NE(check.errors().find(path + ":2:12: \"priority\" is 100"), std::string::npos);
}

class TenMistakes : public Loopback, public testing::WithParamInterface<Words> {};

TEST_P(TenMistakes, GiveTenLinesAndStatusTwo) {
    const std::string path =
        std::string(TRIBUS_SOURCE_DIR) + "/tests/unit/config/ten_mistakes.toml";
    Words words = GetParam();
    words.insert(words.begin() + 1, path);
    Program& program = start(words);
    EXPECT_EQ(program.end(), 2);
    EXPECT_EQ(program.output(), "");
    std::vector<std::string> places;
    for (const std::string& line : lines_of(program.errors())) {
        if (line.rfind("heap trap", 0) != 0) {
            places.push_back(line.substr(0, line.find(": ")));
        }
    }
    Words expected;
    for (const char* place :
         {"2:12", "5:12", "6:12", "7:12", "11:1", "12:12", "15:8", "19:36", "20:1", "23:10"}) {
        expected.push_back(path + ":" + place);
    }
    EXPECT_EQ(places, expected);
}

INSTANTIATE_TEST_SUITE_P(Commands, TenMistakes,
                         testing::Values(Words{"run"}, Words{"check"},
                                         Words{"simulate", "--in", "receiver=/dev/null"}),
                         [](const auto& words) { return words.param.front(); });

class Help : public Loopback, public testing::WithParamInterface<Words> {};

TEST_P(Help, GoesToStandardOutputAndEndsWithZero) {
    Words words = GetParam();
    words.emplace_back("--help");
    Program& program = start(words);
    EXPECT_EQ(program.end(), 0);
    EXPECT_NE(program.output().find("Usage"), std::string::npos) << program.output();
    EXPECT_EQ(program.errors(), "");
}

INSTANTIATE_TEST_SUITE_P(Everywhere, Help,
                         testing::Values(Words{}, Words{"run"}, Words{"check"}, Words{"schema"},
                                         Words{"demo"}, Words{"simulate"}, Words{"decode"},
                                         Words{"encode"}, Words{"dbc"}),
                         [](const auto& words) {
                             return words.param.empty() ? "program" : words.param.front();
                         });

TEST_F(Loopback, DbcOfTheNativeFormatIsTheShippedFile) {
    Program& program = start({"dbc"});
    EXPECT_EQ(program.end(), 0);
    std::ifstream shipped(std::string(TRIBUS_SOURCE_DIR) + "/deploy/can/native.dbc");
    const std::string text{std::istreambuf_iterator<char>(shipped), {}};
    EXPECT_EQ(program.output(), text);
}

TEST_F(Loopback, DbcOfTheSensorsIsTheShippedFile) {
    Program& program = start({"dbc", "--sensors"});
    EXPECT_EQ(program.end(), 0);
    std::ifstream shipped(std::string(TRIBUS_SOURCE_DIR) + "/deploy/can/sensors.dbc");
    const std::string text{std::istreambuf_iterator<char>(shipped), {}};
    EXPECT_TRUE(program.output() == text);
}

TEST_F(Loopback, DbcTakesTheIdsOfTheConfiguration) {
    Program& program = start({"dbc", "--id", "0x1234500", "--extended"});
    EXPECT_EQ(program.end(), 0);
    // 29-bit ids have bit 31 set in a DBC file.
    EXPECT_NE(program.output().find("BO_ 2166572288 RcA: 8"), std::string::npos);
}

class WrongUse : public Loopback, public testing::WithParamInterface<Words> {};

TEST_P(WrongUse, IsExplainedOnStandardErrorAndEndsWithTwo) {
    Program& program = start(GetParam());
    EXPECT_EQ(program.end(), 2);
    EXPECT_NE(program.errors(), "");
    EXPECT_EQ(program.output(), "");
}

INSTANTIATE_TEST_SUITE_P(
    Arguments, WrongUse,
    testing::Values(Words{}, Words{"fly"}, Words{"run"}, Words{"run", "a.toml", "b.toml"},
                    Words{"check", "/nonexistent/tribus.toml"}, Words{"dbc", "--id", "0x7FF"},
                    Words{"dbc", "--sensors", "--id", "0x7F2"}, Words{"dbc", "--id", "first"},
                    Words{"check", "--format", "xml", "a.toml"}, Words{"demo", "--seconds", "soon"},
                    Words{"demo", "--seconds", "0"}, Words{"simulate"}));

/// The log of `run`, as a terminal with these variables shows it.
class LogInATerminal : public Loopback {
  protected:
    std::string shown(const std::string& variables) {
        FarEnd terminal(folder() / "terminal");
        const std::string config = write_config(main_job());
        Program program(folder(),
                        {"-c", "unset NO_COLOR; exec env " + variables + " \"$0\" run \"$1\" 2>&1",
                         TRIBUS_PROGRAM, config},
                        {.executable = "/bin/sh", .terminal = terminal.path()});
        std::string text;
        EXPECT_TRUE(eventually([&] {
            const Bytes bytes = terminal.receive();
            text.append(bytes.begin(), bytes.end());
            return text.find(" started ") != std::string::npos;
        })) << text;
        program.signal(SIGTERM);
        EXPECT_EQ(program.end(), 0) << text;
        return text;
    }
};

TEST_F(LogInATerminal, HasColoursUnlessThePersonOrTheTerminalForbidsThem) {
    EXPECT_NE(shown("TERM=xterm").find("\x1b["), std::string::npos);
    for (const char* variables : {"TERM=xterm NO_COLOR=1", "TERM=dumb", "-u TERM"}) {
        EXPECT_EQ(shown(variables).find('\x1b'), std::string::npos) << variables;
    }
}

}  // namespace
}  // namespace tribus::test::command_line_test
