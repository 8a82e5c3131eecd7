#include <string>

#include <gtest/gtest.h>

#include "tests/support/shell.h"

/// The built program over logs of CAN frames in the native format.
namespace tribus::program_can_test {
namespace {

using test::Ended;
using test::run_in_shell;
using test::TemporaryFolder;

constexpr std::size_t kSnapshots = 10;

/// Snapshots with 18 different channels, in steps of eighths that classic frames can hold.
std::string frames() {
    std::string lines;
    for (std::size_t snapshot = 0; snapshot < kSnapshots; ++snapshot) {
        lines += "{\"t_us\":" + std::to_string(10'000 * snapshot) +
                 ",\"protocol\":\"can\",\"channels\":[";
        for (std::size_t channel = 0; channel < 18; ++channel) {
            lines += (channel > 0 ? "," : "") + std::to_string(1000 + 20 * channel + snapshot) +
                     (channel % 2 == 1 ? ".5" : "");
        }
        const bool lost = snapshot > 5;
        lines += std::string("],\"frame_lost\":") + (lost ? "true" : "false") +
                 ",\"failsafe\":" + (snapshot > 7 ? "true" : "false") + "}\n";
    }
    return lines;
}

/// Removes the details of the protocol and the summary.
std::string plain(const std::string& json) {
    std::string kept;
    std::istringstream lines(json);
    for (std::string line; std::getline(lines, line);) {
        const std::size_t details = line.find(",\"counter\"");
        if (line.find("summary") == std::string::npos) {
            kept += line.substr(0, details) + (details == std::string::npos ? "\n" : "}\n");
        }
    }
    return kept;
}

class ProgramCan : public testing::Test {
  protected:
    Ended run(const std::string& command) const {
        return run_in_shell("cd '" + folder / "" + "'; " + command);
    }
    TemporaryFolder folder;
};

class ProgramCanVariants : public ProgramCan, public testing::WithParamInterface<const char*> {};

// The decoder needs three snapshots before it trusts a sender.
TEST_P(ProgramCanVariants, DecodeReadsWhatEncodeWrites) {
    folder.write("frames.json", frames());
    const std::string options = GetParam();
    const Ended result = run("\"$TRIBUS\" encode --protocol can " + options +
                             " frames.json > can.log && \"$TRIBUS\" decode --protocol can " +
                             options + " --format json can.log");
    EXPECT_EQ(result.status, 0);
    std::string expected = frames();
    expected.erase(0, expected.find("{\"t_us\":20000"));
    EXPECT_EQ(plain(result.output), expected) << result.output;
}

INSTANTIATE_TEST_SUITE_P(Settings, ProgramCanVariants,
                         testing::Values("", "--fd", "--fd true", "--fd=true", "--fd --extended",
                                         "--crc p01", "--id 0x123", "--id 0x18FF0000 --extended",
                                         "--interface vcan12"));

// 1500 is 0x05DC, 1000 is 0x03E8, the low byte first (@1).
TEST_F(ProgramCan, DbcIsGivenAsInTheConfiguration) {
    folder.write("sticks.dbc",
                 "BO_ 512 Sticks: 4 Node\n"
                 " SG_ Steer : 0|16@1+ (1,0) [0|65535] \"us\" Node\n"
                 " SG_ Speed : 16|16@1+ (1,0) [0|65535] \"us\" Node\n");
    const std::string dbc =
        " --protocol dbc --dbc sticks.dbc --signals '{ Sticks.Steer = 1, Sticks.Speed = 2 }' ";
    const Ended log = run("echo '{\"channels\":[1500,1000]}' | \"$TRIBUS\" encode" + dbc);
    EXPECT_EQ(log.output, "(0000000000.000000) can0 200#DC05E803\n");
    folder.write("can.log", log.output);
    const Ended frames = run("\"$TRIBUS\" decode" + dbc + "--format csv can.log");
    EXPECT_NE(frames.output.find("\n0,1500,1000,,"), std::string::npos) << frames.output;
}

TEST_F(ProgramCan, AutoTellsALogOfCan) {
    folder.write("frames.json", frames());
    const Ended result =
        run("\"$TRIBUS\" encode --protocol can frames.json | \"$TRIBUS\" decode --format csv");
    EXPECT_EQ(result.status, 0);
    EXPECT_NE(result.output.find("\n90000,1009,1029.5,"), std::string::npos) << result.output;
}

TEST_F(ProgramCan, LinesOfAPipeAreDecodedAsTheyCome) {
    folder.write("frames.json", frames());
    // The writer of the pipe keeps it open until a frame has come out of the program.
    const Ended result =
        run("\"$TRIBUS\" encode --protocol can frames.json > can.log; mkfifo log frames; "
            "timeout 120 \"$TRIBUS\" decode --protocol can --format csv < log > frames & "
            "exec 3> log 4< frames; head -n 25 can.log >&3; "
            "while read -r frame <&4; do "
            "case $frame in 20000,*) echo \"$frame\"; break ;; esac; done; "
            "exec 3>&-; cat <&4 > /dev/null; wait");
    EXPECT_EQ(result.output.substr(0, 11), "20000,1002,") << result.output;
}

TEST_F(ProgramCan, EmptyLogHasNoFrames) {
    const Ended result = run(": | \"$TRIBUS\" decode --protocol can --format json");
    EXPECT_EQ(result.status, 0);
    EXPECT_NE(result.output.find("\"can_frames\":0,\"frames\":0,"), std::string::npos);
}

TEST_F(ProgramCan, SerialProtocolRefusesALogOfCan) {
    folder.write("can.log", "(1.000000) can0 123#11\n");
    const Ended result = run("\"$TRIBUS\" decode --protocol ibus can.log");
    EXPECT_EQ(result.status, 2);
    EXPECT_EQ(result.output.substr(0, 77),
              "tribus: can.log: a log of CAN frames, and ibus is not a CAN protocol; allowed");
}

TEST_F(ProgramCan, CanProtocolRefusesBytes) {
    const Ended text = run("echo 20 40 | \"$TRIBUS\" decode --protocol can");
    EXPECT_EQ(text.status, 1);
    EXPECT_EQ(
        text.output,
        "tribus: standard input:1:1: \"20\" is not a time; a line is (1436509052.249713) can0 "
        "123#1122, as candump -L and candump -l write it\n");
    const Ended raw = run("printf '\\017\\000\\000\\000' | \"$TRIBUS\" decode --protocol can");
    EXPECT_EQ(raw.status, 2);
    EXPECT_EQ(raw.output,
              "tribus: standard input: bytes of a serial line, but can is read from CAN frames: "
              "lines such as (1436509052.249713) can0 123#1122, as candump -L writes them\n");
}

TEST_F(ProgramCan, SettingsThatDoNotGoTogetherAreRefused) {
    const Ended result = run("\"$TRIBUS\" decode --protocol can --id 5000 /dev/null");
    EXPECT_EQ(result.status, 2);
    EXPECT_EQ(result.output.substr(0, 51), "tribus: --id: 5000 is too high for ids of 11 bits; ");
}

TEST_F(ProgramCan, SeveralInterfacesNeedAName) {
    folder.write("can.log", "(1.000000) can0 123#11\n(1.000000) can1 123#11\n");
    const Ended result = run("\"$TRIBUS\" decode --protocol can can.log");
    EXPECT_EQ(result.status, 1);
    EXPECT_EQ(result.output,
              "tribus: can.log: frames of several interfaces, \"can0\", \"can1\"; select one with "
              "--interface NAME\n");
    EXPECT_EQ(run("\"$TRIBUS\" decode --protocol can --interface can1 can.log").status, 0);
}

TEST_F(ProgramCan, InterfaceBelongsToLogsOnly) {
    EXPECT_EQ(run("echo 20 40 | \"$TRIBUS\" decode --interface can0").output,
              "tribus: --interface: standard input is not a candump log, and only such a log has "
              "interfaces; leave it out\n");
    EXPECT_EQ(run("\"$TRIBUS\" encode --protocol sbus --interface can0 < /dev/null").output,
              "tribus: --interface: sbus does not run on CAN; leave it out\n");
}

TEST_F(ProgramCan, FormatsGoWithTheKindOfProtocol) {
    const Ended hex = run("\"$TRIBUS\" encode --protocol can --format hex < /dev/null");
    EXPECT_EQ(hex.status, 2);
    EXPECT_EQ(hex.output, "tribus: --format hex: can runs on CAN; allowed: candump\n");
    const Ended log = run("\"$TRIBUS\" encode --protocol ibus --format candump < /dev/null");
    EXPECT_EQ(log.status, 2);
    EXPECT_EQ(
        log.output,
        "tribus: --format candump: ibus does not run on CAN; allowed: binary, hex, timed, vcd\n");
}

TEST_F(ProgramCan, InterfaceThatLinuxCouldNotHaveIsRefused) {
    const Ended result = run("\"$TRIBUS\" encode --protocol can --interface 'can 0' < /dev/null");
    EXPECT_EQ(result.status, 2);
    EXPECT_EQ(result.output,
              "tribus: --interface can 0: interface names have at most 15 characters and no "
              "blanks\n");
}

/// A configuration whose bus output has other settings than the defaults.
constexpr const char* kTwoSides = R"([input.receiver]
protocol = "ibus"
device   = "/dev/ttyA"
[output.bus]
protocol  = "can"
interface = "can0"
id        = 0x123450
extended  = true
[pipeline.main]
from = "receiver"
to   = "bus"
)";

TEST_F(ProgramCan, ProtocolAndSettingsMayBeThoseOfAConfiguration) {
    folder.write("robot.toml", kTwoSides);
    folder.write("frames.json", frames());
    const Ended encoded = run("\"$TRIBUS\" encode --as robot.toml:bus frames.json");
    EXPECT_EQ(encoded.status, 0) << encoded.output;
    EXPECT_NE(encoded.output.find(" can0 00123450#"), std::string::npos) << encoded.output;
    folder.write("bus.log", encoded.output);
    const Ended decoded = run("\"$TRIBUS\" decode --as robot.toml:bus --format json bus.log");
    EXPECT_EQ(decoded.status, 0);
    const Ended named =
        run("\"$TRIBUS\" decode --protocol can --id 0x123450 --extended true --format json "
            "bus.log");
    EXPECT_EQ(decoded.output, named.output);
}

TEST_F(ProgramCan, UnknownNameOfAConfigurationIsToldWithThoseThatThereAre) {
    folder.write("robot.toml", kTwoSides);
    const Ended decoded = run("\"$TRIBUS\" decode --as robot.toml:buss /dev/null");
    EXPECT_EQ(decoded.status, 2);
    EXPECT_NE(decoded.output.find("did you mean \"bus\"?"), std::string::npos) << decoded.output;
}

TEST_F(ProgramCan, SettingsBesideThoseOfAConfigurationAreRefused) {
    folder.write("robot.toml", kTwoSides);
    EXPECT_EQ(run("\"$TRIBUS\" decode --as robot.toml:bus --fd true /dev/null").status, 2);
    EXPECT_EQ(run("\"$TRIBUS\" encode --as robot.toml:bus --protocol can /dev/null").status, 2);
}

}  // namespace
}  // namespace tribus::program_can_test
