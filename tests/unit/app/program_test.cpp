#include <string>

#include <gtest/gtest.h>

#include "tests/support/shell.h"

/// The built program, started by a shell: what shows only from outside.
namespace tribus::program_test {
namespace {

using test::Ended;
using test::run_in_shell;

// i.Bus, 14 channels (IBusBM, comment in its source).
const std::string kHex =
    "20 40 db 05 dc 05 54 05 dc 05 e8 03 d0 07 d2 05 e8 03 dc 05 dc 05 dc 05 dc 05 dc 05 dc 05 da "
    "f3";

TEST(Program, DecodePipedIntoEncodeGivesTheSameBytes) {
    const Ended result = run_in_shell("echo '" + kHex +
                                      "' | \"$TRIBUS\" decode --protocol ibus --format json"
                                      " | \"$TRIBUS\" encode --protocol ibus --format hex");
    EXPECT_EQ(result.status, 0);
    EXPECT_EQ(result.output, kHex + "\n");
}

TEST(Program, EncodesEighteenChannelsUnlessToldOtherwise) {
    const std::string frame =
        "echo '{\"channels\":[1500,1500,1500,null,null,null,null,null,null,null,null,null,null,"
        "null,1500]}' | \"$TRIBUS\" encode --protocol ibus --format hex";
    EXPECT_EQ(run_in_shell(frame).output.substr(0, 17), "20 40 dc c5 dc d5");
    EXPECT_EQ(run_in_shell(frame + " --channels 14").output.substr(0, 17), "20 40 dc 05 dc 05");
}

/// ArrayCommand has room for 15 servos. More channels in the input are no reason to refuse it.
TEST(Program, EncodesNoMoreChannelsThanTheProtocolHas) {
    const Ended result = run_in_shell(
        "echo '{\"channels\":[1500,1500,1500]}' | \"$TRIBUS\" encode --protocol dronecan "
        "--carries servos --node_id 5");
    EXPECT_EQ(result.status, 0) << result.output;
    EXPECT_EQ(result.output.find("channels"), std::string::npos) << result.output;
}

TEST(Program, AloneShowsItsHelpAsWrongUse) {
    const Ended help = run_in_shell("\"$TRIBUS\" --help");
    const Ended result = run_in_shell("\"$TRIBUS\" 2>&1 >/dev/null");
    EXPECT_EQ(result.status, 2);
    EXPECT_EQ(result.output, help.output);
}

/// The exit status tells a service whether another start may help.
TEST(Program, RunEndsOtherwiseForAFileThatIsMissingThanForOneWithMistakes) {
    EXPECT_EQ(run_in_shell("\"$TRIBUS\" run /no/such/file.toml").status, 1);
    EXPECT_EQ(run_in_shell("echo 'x = 1' | \"$TRIBUS\" run /dev/stdin").status, 2);
    EXPECT_EQ(run_in_shell("\"$TRIBUS\" check /no/such/file.toml").status, 2);
}

TEST(Program, ReaderThatGoesAwayIsNoFailure) {
    const Ended result =
        run_in_shell("{ for i in $(seq 20000); do echo '" + kHex +
                     "'; done; } | \"$TRIBUS\" decode --protocol ibus | head -n 1");
    EXPECT_EQ(result.status, 0);
    EXPECT_EQ(result.output.find("tribus:"), std::string::npos) << result.output;
}

TEST(Program, FullDeviceIsAFailure) {
    const Ended result = run_in_shell("echo '" + kHex + "' | \"$TRIBUS\" decode > /dev/full");
    EXPECT_EQ(result.status, 1);
    EXPECT_EQ(result.output, "tribus: cannot write to standard output\n");
}

TEST(Program, FileThatCannotBeReadEndsWithOne) {
    const Ended result = run_in_shell("\"$TRIBUS\" decode /nonexistent/file");
    EXPECT_EQ(result.status, 1);
    EXPECT_EQ(result.output, "tribus: /nonexistent/file: No such file or directory\n");
    EXPECT_EQ(run_in_shell("\"$TRIBUS\" encode --protocol sbus /").status, 1);
}

TEST(Program, MistakeInAFileEndsWithOneAndSaysHowItWasRead) {
    const Ended result = run_in_shell("echo '20 4x' | \"$TRIBUS\" decode");
    EXPECT_EQ(result.status, 1);
    EXPECT_EQ(
        result.output,
        "tribus: standard input:1:4: \"4x\" is not a byte; a byte is two hex digits, with a space "
        "between bytes: 20 40 dc 05 (read as hex; --input-format raw, hex, timed or saleae "
        "selects another format)\n");
}

TEST(Program, WrongUseEndsWithTwo) {
    EXPECT_EQ(run_in_shell("\"$TRIBUS\"").status, 2);
    EXPECT_EQ(run_in_shell("\"$TRIBUS\" decode --format xml").status, 2);
    EXPECT_EQ(run_in_shell("\"$TRIBUS\" decode --protocol nonsense < /dev/null").status, 2);
    EXPECT_EQ(run_in_shell("\"$TRIBUS\" encode < /dev/null").status, 2);
    EXPECT_EQ(run_in_shell("\"$TRIBUS\" encode --protocol auto < /dev/null").status, 2);
}

TEST(Program, HelpEndsWithZero) {
    EXPECT_EQ(run_in_shell("\"$TRIBUS\" --help").status, 0);
    EXPECT_EQ(run_in_shell("\"$TRIBUS\" decode --help").status, 0);
}

}  // namespace
}  // namespace tribus::program_test
