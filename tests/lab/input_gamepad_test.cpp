#include <linux/input.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/lab/guest.h"
#include "tests/lab/input_devices.h"
#include "tests/loopback/few_descriptors.h"
#include "tests/loopback/loopback.h"

/// The built program with a gamepad of the kernel (uinput) as its input, SBUS as its output.
namespace tribus::test::input_gamepad_test {
namespace {

constexpr const char* kName = "pad of the laboratory";

class LabGamepad : public Loopback {
  protected:
    LabGamepad() : servos_((require_guest(), device("servos"))), bank_(servos_) {
        shell("modprobe -a uinput evdev");
        pad_.emplace(kName);
        link();
    }
    /// A name as udev makes one under /dev/input/by-id, because the number may change.
    void link() {
        std::filesystem::remove(folder() / "pad");
        std::filesystem::create_symlink(pad_->device(), folder() / "pad");
    }
    std::string config(const std::string& lines = "") {
        return write_config("[input.pad]\nprotocol = \"gamepad\"\ndevice = \"@pad\"\n" + lines +
                            "[output.servos]\nprotocol = \"sbus\"\ndevice = \"@servos\"\n"
                            "[pipeline.main]\nfrom = \"pad\"\nto = \"servos\"\n"
                            "[pipeline.main.failsafe]\nhold = \"0s\"\nrecover = \"0s\"\n");
    }
    /// Waits until channels 1 to 4 are good, and so many microseconds, to a step of SBUS.
    bool sends(const std::vector<int>& microseconds) {
        return eventually([&] {
            bool seen = false;
            for (const SbusSight& sight : bank_.listen()) {
                bool same = sight.good();
                for (std::size_t i = 0; i < microseconds.size(); ++i) {
                    same = same && std::abs(sight.raw[i] - sbus_raw(microseconds[i])) <= 1;
                }
                seen = seen || same;
            }
            return seen;
        });
    }
    bool sends_failsafe() {
        return eventually([&] {
            bool seen = false;
            for (const SbusSight& sight : bank_.listen()) {
                seen = seen || sight.failsafe;
            }
            return seen;
        });
    }
    VirtualGamepad& pad() { return *pad_; }
    void unplug() { pad_.reset(); }
    void plug() {
        pad_.emplace(kName);
        link();
    }
    ServoBank& bank() { return bank_; }

  private:
    FarEnd& servos_;
    ServoBank bank_;
    std::optional<VirtualGamepad> pad_;
};

TEST_F(LabGamepad, MovesSbusServosAndHoldsThemWithoutAnEvent) {
    Program& program = run(config());
    EXPECT_TRUE(sends({1500, 1500, 1500, 1500})) << program.errors();
    pad().change({{EV_ABS, ABS_RX, 100}, {EV_ABS, ABS_RY, -100}, {EV_ABS, ABS_Y, -50}});
    EXPECT_TRUE(sends({2000, 1000, 1750, 1500})) << program.errors();
    // The kernel is silent while nothing moves; that is no loss.
    bank().listen();
    shell("sleep 1");
    const auto sights = bank().listen();
    ASSERT_GT(sights.size(), 20U);
    for (const SbusSight& sight : sights) {
        ASSERT_TRUE(sight.good());
    }
    expect_clean_end(program);
}

TEST_F(LabGamepad, ItsRemovalIsFailsafeWithinAPeriod) {
    Program& program = run(config());
    pad().move(ABS_RX, 100);
    EXPECT_TRUE(sends({2000, 1500, 1500, 1500})) << program.errors();
    bank().listen();
    unplug();
    std::vector<SbusSight> sights;
    EXPECT_TRUE(eventually([&] {
        for (const SbusSight& sight : bank().listen()) {
            sights.push_back(sight);
        }
        return !sights.empty() && sights.back().failsafe;
    })) << program.errors();
    std::size_t good = 0;
    for (const SbusSight& sight : sights) {
        good += sight.good() ? 1U : 0U;
    }
    // Frames that were on their way when the device went, and one more.
    EXPECT_LE(good, 2U);
    expect_clean_end(program);
}

TEST_F(LabGamepad, AfterItsReturnSticksMustRestAndAButtonBePressed) {
    Program& program = run(config());
    EXPECT_TRUE(sends({1500, 1500, 1500, 1500})) << program.errors();
    unplug();
    EXPECT_TRUE(sends_failsafe());
    plug();
    pad().move(ABS_RX, 100);
    EXPECT_TRUE(program.says("back")) << program.errors();
    shell("sleep 0.5");
    bank().listen();
    shell("sleep 0.5");
    for (const SbusSight& sight : bank().listen()) {
        ASSERT_FALSE(sight.good()) << "a stick is held";
    }
    pad().move(ABS_RX, 0);
    shell("sleep 0.3");
    pad().press(BTN_EAST);
    EXPECT_TRUE(sends({1500, 1500, 1500, 1500})) << program.errors();
    pad().release(BTN_EAST);
    pad().move(ABS_RX, 100);
    EXPECT_TRUE(sends({2000, 1500, 1500, 1500})) << program.errors();
    expect_clean_end(program);
}

TEST_F(LabGamepad, ReadsTheWholeStateAfterTheKernelDroppedEvents) {
    Program& program = run(config());
    EXPECT_TRUE(sends({1500, 1500, 1500, 1500})) << program.errors();
    program.signal(SIGSTOP);
    // The kernel keeps some 64 events for each reader.
    for (int i = 0; i < 2000; ++i) {
        pad().move(ABS_RX, i % 100);
    }
    pad().change({{EV_ABS, ABS_RX, -100}, {EV_ABS, ABS_X, 100}});
    program.signal(SIGCONT);
    EXPECT_TRUE(sends({1000, 1500, 1500, 2000})) << program.errors();
    expect_clean_end(program);
}

TEST_F(LabGamepad, IsOfItsProgramAloneUntilThatEndsAlsoWhileItIsStopped) {
    Program& program = run(config());
    EXPECT_TRUE(sends({1500, 1500, 1500, 1500})) << program.errors();
    const InputReader other(pad().device());
    EXPECT_FALSE(other.grab());
    program.signal(SIGSTOP);
    EXPECT_FALSE(other.grab());
    program.signal(SIGKILL);
    program.end();
    EXPECT_TRUE(other.grab());
}

TEST_F(LabGamepad, CountsOnlyWhileTheDeadMansButtonIsPressed) {
    Program& program = run(config("dead_man = \"BTN_TL\"\n"));
    EXPECT_TRUE(sends_failsafe()) << program.errors();
    pad().press(BTN_TL);
    EXPECT_TRUE(sends({1500, 1500, 1500, 1500})) << program.errors();
    pad().release(BTN_TL);
    EXPECT_TRUE(sends_failsafe()) << program.errors();
    expect_clean_end(program);
}

TEST_F(LabGamepad, IsLostWhenAZombieReportsNothingForTheActivityTimeout) {
    Program& program = run(config("activity_timeout = \"1s\"\n"));
    pad().move(ABS_RX, 100);
    EXPECT_TRUE(sends({2000, 1500, 1500, 1500})) << program.errors();
    EXPECT_TRUE(sends_failsafe()) << program.errors();
    pad().move(ABS_RX, 50);
    EXPECT_TRUE(sends({1750, 1500, 1500, 1500})) << program.errors();
    expect_clean_end(program);
}

TEST_F(LabGamepad, SaysThatAnotherProgramHasTakenIt) {
    const InputReader other(pad().device());
    ASSERT_TRUE(other.grab());
    Program& program = start({"run", config()});
    EXPECT_TRUE(
        program.says("another program has taken it for itself; stop it, or set grab = "
                     "false"))
        << program.errors();
}

TEST_F(LabGamepad, SaysWhichGroupMayReadIt) {
    shell("chmod 660 " + pad().device());
    const std::string file = config();
    shell("chmod -R a+rwX " + folder().string());
    const ShellResult result = run_shell(
        "setpriv --reuid nobody --regid nogroup --clear-groups "
        "timeout 5 " TRIBUS_PROGRAM " run " +
        file);
    EXPECT_NE(result.output.find("this user may not read it; join the group input"),
              std::string::npos)
        << result.output;
}

TEST_F(LabGamepad, WithTooFewDescriptorsTheProgramEndsAndSaysSo) {
    const std::string file = write_config(
        "[input.pad]\nprotocol = \"gamepad\"\ndevice = \"@pad\"\n"
        "[output.simulator]\nprotocol = \"joystick\"\nname = \"few\"\n"
        "[pipeline.main]\nfrom = \"pad\"\nto = \"simulator\"\n");
    const DescriptorTrials trials = run_with_few_descriptors(folder(), file);
    EXPECT_GT(trials.ended, 0);
    EXPECT_GT(trials.ran, 0);
}

}  // namespace
}  // namespace tribus::test::input_gamepad_test
