#include <sstream>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/support/shell.h"

/// Log messages of `tribus simulate` besides its summary.
namespace tribus::simulate_log_test {
namespace {

using test::run_in_shell;
using test::TemporaryFolder;

/// Returns i.Bus frames of 14 channels every 7 ms for 1.05 s.
std::string receiver_frames() {
    std::string lines;
    for (int frame = 0; frame < 150; ++frame) {
        lines += fmt::format(
            "{{\"t_us\":{},\"channels\":[1500,1500,1100,1500,1500,1500,1500,1500,1500,1500,1500,"
            "1500,1500,1500]}}\n",
            7000 * frame);
    }
    return lines;
}

/// Returns the lines that contain `part`.
std::string lines_with(const std::string& part, const std::string& text) {
    std::istringstream all(text);
    std::string found;
    for (std::string line; std::getline(all, line);) {
        found += line.find(part) != std::string::npos ? line + "\n" : "";
    }
    return found;
}

class SimulateLogTest : public testing::Test {
  protected:
    /// Returns the log of a simulation from i.Bus to this protocol, with more configuration lines.
    std::string log_of_ibus_to(const std::string& protocol, const std::string& more) const {
        folder_.write("c.toml",
                      "[input.receiver]\nprotocol = \"ibus\"\ndevice = \"/dev/ttyA\"\n"
                      "[output.servos]\nprotocol = \"" +
                          protocol +
                          "\"\ndevice = \"/dev/ttyB\"\n"
                          "[pipeline.main]\nfrom = \"receiver\"\nto = \"servos\"\n" +
                          more);
        folder_.write("frames.json", receiver_frames());
        return run(
            "\"$TRIBUS\" encode --protocol ibus --format timed frames.json > in.txt && "
            "\"$TRIBUS\" simulate c.toml --in receiver=in.txt --out servos=out.txt "
            "--tail 1s");
    }
    std::string run(const std::string& command) const {
        const test::Ended ended = run_in_shell("cd '" + folder_ / "" + "'; " + command);
        EXPECT_EQ(ended.status, 0) << ended.output;
        return ended.output;
    }
    TemporaryFolder folder_;
};

TEST_F(SimulateLogTest, SaysOfHeldValuesThatTheyAreMarkedWhereTheWireCan) {
    EXPECT_NE(log_of_ibus_to("sbus", "")
                  .find("output servos: holding the last values, marked frame-lost; waits"),
              std::string::npos);
}

TEST_F(SimulateLogTest, SaysOfHeldValuesThatTheyAreUnmarkedWhereTheWireCannot) {
    EXPECT_NE(log_of_ibus_to("ibus", "")
                  .find("output servos: holding the last values, unmarked: its protocol has no "
                        "frame-lost mark; waits"),
              std::string::npos);
}

TEST_F(SimulateLogTest, SaysOnceThatAMapReadsChannelsThatDoNotCome) {
    const std::string log =
        log_of_ibus_to("sbus", "[pipeline.main.channels]\n3 = 17\n4 = { from = 15 }\n5 = 1\n");
    const std::string lines = lines_with("preset", log);
    EXPECT_TRUE(
        lines.ends_with("output servos: channels 3, 4 send their presets: the channels that they "
                        "are mapped from are absent\n"))
        << log;
    EXPECT_EQ(lines.find('\n'), lines.size() - 1) << lines;
}

TEST_F(SimulateLogTest, SaysNothingOfChannelsThatNoMapNames) {
    EXPECT_EQ(lines_with("preset", log_of_ibus_to("sbus", "")), "");
}

TEST_F(SimulateLogTest, NamesTheSignalWithoutAValueInsteadOfTheReceiver) {
    folder_.write("x.dbc", "BO_ 256 M: 2 A\n SG_ Steer : 0|16@1+ (1,0) [800|2200] \"us\" B\n");
    folder_.write("c.toml",
                  "[input.bus]\nprotocol = \"dbc\"\ninterface = \"can0\"\ndbc = \"x.dbc\"\n"
                  "signals.M.Steer = 1\n"
                  "[output.servos]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyB\"\n"
                  "[pipeline.main]\nfrom = \"bus\"\nto = \"servos\"\n");
    // 1500 is 0x05DC, 3000 is 0x0BB8.
    std::string frames;
    for (int i = 0; i < 100; ++i) {
        frames += fmt::format("({:.6f}) can0 100#{}\n", 1 + 0.02 * i, i < 50 ? "DC05" : "B80B");
    }
    folder_.write("can.log", frames);
    const std::string log =
        run("\"$TRIBUS\" simulate c.toml --in bus=can.log --out servos=out.txt");
    const std::string lines = lines_with("input bus: radio lost", log);
    EXPECT_TRUE(lines.ends_with(
        "input bus: radio lost (message M, signal Steer: 3000 is outside of [800|2200])\n"))
        << log;
    EXPECT_EQ(log.find("the receiver says failsafe"), std::string::npos) << log;
}

class TwoSendersOfAMessage : public SimulateLogTest {
  protected:
    /// One message every 20 ms. With `second` there is another one every 100 ms, 16 ms after one
    /// of these.
    std::string log_of(bool second, const std::string& more_signals) const {
        folder_.write("x.dbc",
                      "VERSION \"\"\nBU_: A B\nBO_ 1 Command: 2 A\n"
                      " SG_ S1 : 0|8@1+ (4,1000) [1000|2000] \"\" B\n"
                      " SG_ Count : 8|4@1+ (1,0) [0|15] \"\" B\n");
        folder_.write("c.toml",
                      "[input.joystick]\nprotocol = \"dbc\"\ninterface = \"can0\"\n"
                      "dbc = \"x.dbc\"\n[input.joystick.signals.Command]\nS1 = { channel = 1 }\n" +
                          more_signals +
                          "[output.servos]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyB\"\n"
                          "[pipeline.main]\nfrom = \"joystick\"\nto = \"servos\"\n");
        std::string log;
        for (int i = 0; i < 150; ++i) {
            log += fmt::format("({:.6f}) can0 001#40{:02X}\n", 1 + 0.02 * i, i % 16);
            if (second && i % 5 == 0) {
                log += fmt::format("({:.6f}) can0 001#80{:02X}\n", 1.016 + 0.02 * i, 7);
            }
        }
        folder_.write("can.log", log);
        return run("\"$TRIBUS\" simulate c.toml --in joystick=can.log --out servos=out.txt");
    }
};

constexpr std::string_view kSaid =
    "input joystick: its frames come with two periods, as from two senders";

TEST_F(TwoSendersOfAMessage, WithoutACounterAreSaidOnce) {
    const std::string lines = lines_with("two periods", log_of(true, ""));
    EXPECT_NE(lines.find(kSaid), std::string::npos) << lines;
    EXPECT_EQ(lines.find('\n'), lines.size() - 1) << lines;
}

TEST_F(TwoSendersOfAMessage, WithACounterAreKeptApartAndNotSaid) {
    EXPECT_EQ(lines_with("two periods", log_of(true, "Count = { counter = true }\n")), "");
}

TEST_F(TwoSendersOfAMessage, AreNotSaidOfOne) {
    EXPECT_EQ(lines_with("two periods", log_of(false, "")), "");
}

}  // namespace
}  // namespace tribus::simulate_log_test
