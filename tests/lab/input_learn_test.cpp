#include <linux/input.h>

#include <csignal>
#include <ctime>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/lab/guest.h"
#include "tests/lab/input_devices.h"
#include "tests/loopback/loopback.h"

/// `tribus learn` with a gamepad of the kernel (uinput) in a hand.
namespace tribus::test::input_learn_test {
namespace {

class LabLearn : public Loopback {
  protected:
    LabLearn() {
        require_guest();
        shell("modprobe -a uinput evdev");
        pad_.emplace("pad of the laboratory");
        std::filesystem::create_symlink(pad_->device(), path());
    }
    /// A name as a rule of udev makes one.
    std::string path() const { return (folder() / "pad").string(); }
    /// Moves a stick to its end, and lets go.
    void move(int axis, int end) {
        pad_->move(axis, end / 2);
        shell("sleep 0.1");
        pad_->move(axis, end);
        shell("sleep 0.3");
        pad_->move(axis, 0);
    }
    void press(int button, const std::string& seconds) {
        pad_->press(button);
        shell("sleep " + seconds);
        pad_->release(button);
    }
    /// A short press. A program that sleeps takes a second in an emulated machine.
    void tap(int button) {
        pad_->press(button);
        const timespec moment{.tv_sec = 0, .tv_nsec = 100'000'000};
        ::nanosleep(&moment, nullptr);
        pad_->release(button);
    }
    void move_four_sticks(const Program& program) {
        EXPECT_TRUE(program.says("Channel 1,")) << program.errors();
        move(ABS_RX, 100);
        EXPECT_TRUE(program.says("Channel 2,")) << program.errors();
        move(ABS_RY, 100);
        EXPECT_TRUE(program.says("Channel 3,")) << program.errors();
        move(ABS_Y, -100);
        EXPECT_TRUE(program.says("Channel 4,")) << program.errors();
        move(ABS_X, 100);
        EXPECT_TRUE(program.says("Channel 5:")) << program.errors();
    }
    VirtualGamepad& pad() { return *pad_; }
    void unplug() { pad_.reset(); }

  private:
    std::optional<VirtualGamepad> pad_;
};

TEST_F(LabLearn, WithoutATerminalPrintsATableThatCheckAccepts) {
    Program& program = start({"learn", path()});
    move_four_sticks(program);
    press(BTN_SOUTH, "1");
    EXPECT_TRUE(program.says("Channel 6:")) << program.errors();
    tap(BTN_EAST);
    // Nobody can say that there are no more, so that takes a while.
    EXPECT_TRUE(program.says("Channel 7:")) << program.errors();
    shell("sleep 10");
    EXPECT_TRUE(program.says("Dead man's button")) << program.errors();
    press(BTN_TL, "2");
    EXPECT_EQ(program.end(), 0) << program.errors();
    const std::string table = program.output();
    EXPECT_EQ(table, "[input.pad]\nprotocol = \"gamepad\"\ndevice   = \"" + path() +
                         "\"\n"
                         "axes     = { ABS_RX = 1, ABS_RY = 2, "
                         "ABS_Y = { channel = 3, reverse = true }, ABS_X = 4 }\n"
                         "buttons  = { BTN_SOUTH = 5, BTN_EAST = { channel = 6, toggle = true } }\n"
                         "dead_man = \"BTN_TL\"\n");
    Program& check = start({"check", write_config(table + "[output.servos]\nprotocol = \"sbus\"\n"
                                                          "device = \"@servos\"\n[pipeline.main]\n"
                                                          "from = \"pad\"\nto = \"servos\"\n")});
    EXPECT_EQ(check.end(), 0) << check.errors();
}

TEST_F(LabLearn, AtATerminalEnterLeavesControlsOut) {
    FarEnd terminal(folder() / "terminal");
    Program& program = start({"learn", path()}, {.terminal = terminal.path()});
    const auto enter_at = [&](const std::string& prompt) {
        EXPECT_TRUE(program.says(prompt)) << program.errors();
        terminal.send(Bytes{'\n'});
    };
    EXPECT_TRUE(program.says("Channel 1,")) << program.errors();
    move(ABS_X, 100);
    enter_at("Channel 2,");
    enter_at("Channel 3,");
    enter_at("Channel 4,");
    enter_at("Channel 5:");
    enter_at("Dead man's button");
    EXPECT_EQ(program.end(), 0) << program.errors();
    std::string printed;
    for (const std::uint8_t letter : terminal.receive()) {
        printed += static_cast<char>(letter);
    }
    EXPECT_NE(printed.find("axes     = { ABS_X = 1 }"), std::string::npos) << printed;
    EXPECT_NE(program.errors().find("dead_man = \"BTN_TL\""), std::string::npos)
        << "a suggestion: " << program.errors();
}

TEST_F(LabLearn, PrintsWhatReplacesTheLinesOfAnInputToAProgram) {
    FarEnd person(folder() / "person");
    const std::string file = write_config(
        "[input.mine]\nprotocol = \"gamepad\"\ndevice = \"@pad\"\n"
        "[output.servos]\nprotocol = \"sbus\"\ndevice = \"@servos\"\n"
        "[pipeline.main]\nfrom = \"mine\"\nto = \"servos\"\n");
    Program& program =
        start({"learn", file + ":mine", "--format", "json"}, {.terminal = person.path()});
    std::string printed;
    const auto go_on_at = [&](const std::string& prompt) {
        EXPECT_TRUE(eventually([&] {
            for (const std::uint8_t letter : person.receive()) {
                printed += static_cast<char>(letter);
            }
            return printed.find(prompt) != std::string::npos;
        })) << printed
            << program.errors();
    };
    const auto go_on = [&] { person.send(Bytes{'\n'}); };
    go_on_at(R"({"step":"control","text":"Let go)");
    shell("sleep 1.5");
    go_on();
    go_on_at("Channel 1,");
    move(ABS_X, -100);
    shell("sleep 0.2");
    go_on();
    go_on_at("Channel 1 is ABS_X, reversed. Channel 2,");
    go_on();
    go_on_at("Channel 3,");
    go_on();
    go_on_at("Channel 4,");
    go_on();
    go_on_at("Channel 5:");
    go_on();
    go_on_at("Dead man's button");
    go_on();
    go_on_at(R"({"step":"done",)");
    EXPECT_EQ(program.end(), 0) << program.errors();
    EXPECT_NE(printed.find(R"("lines":["axes     = { ABS_X = { channel = 1, reverse = true } }",)"
                           R"("buttons  = {}"])"),
              std::string::npos)
        << printed;
}

TEST_F(LabLearn, SaysThatThePadWasUnplugged) {
    Program& program = start({"learn", path()});
    EXPECT_TRUE(program.says("Channel 1,")) << program.errors();
    unplug();
    EXPECT_EQ(program.end(), 1);
    EXPECT_NE(program.errors().find("it was unplugged, or its Bluetooth link ended"),
              std::string::npos)
        << program.errors();
    EXPECT_EQ(program.output(), "");
}

TEST_F(LabLearn, EndsByCtrlCWithoutLines) {
    Program& program = start({"learn", path()});
    EXPECT_TRUE(program.says("Channel 1,")) << program.errors();
    move(ABS_X, 100);
    EXPECT_TRUE(program.says("Channel 2,")) << program.errors();
    program.signal(SIGINT);
    EXPECT_EQ(program.end(), 130);
    EXPECT_NE(program.errors().find("interrupted; nothing was learned"), std::string::npos);
    EXPECT_EQ(program.output(), "");
}

TEST_F(LabLearn, RefusesAPadThatDoesNotRest) {
    pad().press(BTN_SOUTH);
    Program& program = start({"learn", path()});
    EXPECT_TRUE(program.says("Let go of all sticks")) << program.errors();
    shell("sleep 10");
    EXPECT_EQ(program.end(), 1) << program.errors();
    EXPECT_NE(program.errors().find("something is pressed or moves although nobody touches it"),
              std::string::npos)
        << program.errors();
}

TEST_F(LabLearn, SaysThatAnotherProgramHasThePad) {
    const InputReader other(pad().device());
    ASSERT_TRUE(other.grab());
    Program& program = start({"learn", path()});
    EXPECT_EQ(program.end(), 1);
    EXPECT_NE(program.errors().find("another program has taken it for itself; stop it"),
              std::string::npos)
        << program.errors();
}

TEST_F(LabLearn, RefusesADeviceThatIsNoGamepad) {
    const VirtualGamepad keyboard("keyboard of the laboratory", {KEY_A});
    Program& program = start({"learn", keyboard.device()});
    EXPECT_EQ(program.end(), 1);
    EXPECT_NE(program.errors().find("\"keyboard of the laboratory\" is no gamepad"),
              std::string::npos)
        << program.errors();
}

TEST_F(LabLearn, SaysWhichGroupMayReadIt) {
    shell("chmod 660 " + pad().device());
    shell("chmod -R a+rwX " + folder().string());
    const ShellResult result =
        run_shell("setpriv --reuid nobody --regid nogroup --clear-groups timeout 5 " TRIBUS_PROGRAM
                  " learn " +
                  pad().device());
    EXPECT_NE(result.output.find("this user may not read it; join the group input"),
              std::string::npos)
        << result.output;
}

}  // namespace
}  // namespace tribus::test::input_learn_test
