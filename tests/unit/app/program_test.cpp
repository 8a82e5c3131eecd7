#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <string>

#include <gtest/gtest.h>

/// The built program, as a shell starts it: what only shows from outside.
namespace tribus {
namespace {

struct Ended {
    int status = -1;
    std::string output;
};

/// `command` is shell text in which $TRIBUS is the program; errors are part of the output.
Ended run(const std::string& command) {
    const std::string script = "exec 2>&1; TRIBUS='" TRIBUS_PROGRAM "'; " + command;
    std::FILE* const pipe = ::popen(script.c_str(), "r");
    Ended result;
    std::array<char, 4096> buffer{};
    while (pipe != nullptr && std::fgets(buffer.data(), buffer.size(), pipe) != nullptr) {
        result.output += buffer.data();
    }
    const int status = pipe == nullptr ? -1 : ::pclose(pipe);
    result.status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    return result;
}

// i.Bus, 14 channels (IBusBM, comment in its source).
const std::string kHex =
    "20 40 db 05 dc 05 54 05 dc 05 e8 03 d0 07 d2 05 e8 03 dc 05 dc 05 dc 05 dc 05 dc 05 dc 05 da "
    "f3";

TEST(Program, DecodePipedIntoEncodeGivesTheSameBytes) {
    const Ended result = run("echo '" + kHex +
                             "' | \"$TRIBUS\" decode --protocol ibus --format json"
                             " | \"$TRIBUS\" encode --protocol ibus --format hex");
    EXPECT_EQ(result.status, 0);
    EXPECT_EQ(result.output, kHex + "\n");
}

TEST(Program, EncodesEighteenChannelsUnlessToldOtherwise) {
    const std::string frame =
        "echo '{\"channels\":[1500,1500,1500,null,null,null,null,null,null,null,null,null,null,"
        "null,1500]}' | \"$TRIBUS\" encode --protocol ibus --format hex";
    EXPECT_EQ(run(frame).output.substr(0, 17), "20 40 dc c5 dc d5");
    EXPECT_EQ(run(frame + " --channels 14").output.substr(0, 17), "20 40 dc 05 dc 05");
}

TEST(Program, ReaderThatGoesAwayIsNoFailure) {
    const Ended result = run("{ for i in $(seq 20000); do echo '" + kHex +
                             "'; done; } | \"$TRIBUS\" decode --protocol ibus | head -n 1");
    EXPECT_EQ(result.status, 0);
    EXPECT_EQ(result.output.find("tribus:"), std::string::npos) << result.output;
}

TEST(Program, FullDeviceIsAFailure) {
    const Ended result = run("echo '" + kHex + "' | \"$TRIBUS\" decode > /dev/full");
    EXPECT_EQ(result.status, 1);
    EXPECT_EQ(result.output, "tribus: standard output could not be written\n");
}

TEST(Program, FileThatCannotBeReadEndsWithOne) {
    const Ended result = run("\"$TRIBUS\" decode /nonexistent/file");
    EXPECT_EQ(result.status, 1);
    EXPECT_EQ(result.output, "tribus: /nonexistent/file: No such file or directory\n");
    EXPECT_EQ(run("\"$TRIBUS\" encode --protocol sbus /").status, 1);
}

TEST(Program, MistakeInAFileEndsWithOneAndSaysHowItWasRead) {
    const Ended result = run("echo '20 4x' | \"$TRIBUS\" decode");
    EXPECT_EQ(result.status, 1);
    EXPECT_EQ(result.output,
              "tribus: standard input:1:4: \"4x\" is no byte; a byte is two hex digits, bytes "
              "stand apart: 20 40 dc 05 (read as hex; --input-format raw, hex, timed or saleae "
              "reads it otherwise)\n");
}

TEST(Program, WrongUseEndsWithTwo) {
    EXPECT_EQ(run("\"$TRIBUS\"").status, 2);
    EXPECT_EQ(run("\"$TRIBUS\" decode --format xml").status, 2);
    EXPECT_EQ(run("\"$TRIBUS\" decode --protocol nonsense < /dev/null").status, 2);
    EXPECT_EQ(run("\"$TRIBUS\" encode < /dev/null").status, 2);
    EXPECT_EQ(run("\"$TRIBUS\" encode --protocol auto < /dev/null").status, 2);
}

TEST(Program, HelpEndsWithZero) {
    EXPECT_EQ(run("\"$TRIBUS\" --help").status, 0);
    EXPECT_EQ(run("\"$TRIBUS\" decode --help").status, 0);
}

}  // namespace
}  // namespace tribus
