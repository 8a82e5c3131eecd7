#include <algorithm>
#include <csignal>
#include <cstddef>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/lab/pca9685.h"

/// The PCA9685 by the files of the kernel, or by the chip's device.
namespace tribus::test::pwm_pca9685_registers_test {
namespace {

using namespace pca9685;

constexpr std::size_t kFrames = 400;

TEST_F(LabPwm, IsFoundByDoctorWithWhatItsOutputsDo) {
    shell(
        "cd /sys/class/pwm/pwmchip*; echo 3 >export; cd pwm3; echo 20000000 >period; "
        "echo 1500000 >duty_cycle; echo 1 >enable");
    Program& program = start({"doctor", "pca9685-pwm"});
    EXPECT_EQ(program.end(), 0) << program.errors();
    const auto says = [&](const std::string& part) {
        return program.output().find(part) != std::string::npos;
    };
    // The driver has one more output than the chip: it stands for all of them.
    EXPECT_TRUE(says("pca9685-pwm, outputs 0 to 16")) << program.output();
    EXPECT_TRUE(says("  output  3  on     1500.0 us each 20.000 ms\n")) << program.output();
    EXPECT_TRUE(says("sending pulses: output 3 [pwm.on]")) << program.output();
    shell("echo 3 >$(echo /sys/class/pwm/pwmchip*)/unexport");
    const ShellResult other =
        run_shell("setpriv --reuid nobody --regid nogroup --clear-groups " TRIBUS_PROGRAM
                  " doctor pca9685-pwm");
    EXPECT_EQ(other.status, 1);
    EXPECT_NE(other.output.find("[pwm.permission]"), std::string::npos) << other.output;
}

TEST_F(LabPwm, ARecordingMovesTheRegistersFrameByFrame) {
    FarEnd& receiver = device("receiver");
    Program& program = run(config("timeout = \"5s\"\n"));
    const Registers chip(adapter());
    for (const Capture capture : captures()) {
        const std::vector<Sticks> frames = recorded_sticks(capture);
        ASSERT_GE(frames.size(), kFrames);
        std::size_t changes = 0;
        for (std::size_t i = 0; i < kFrames; ++i) {
            changes += i > 0 && sent(frames[i]) != sent(frames[i - 1]) ? 1U : 0U;
            receiver.send(ibus_bytes(frames[i]));
            ASSERT_TRUE(eventually([&] { return shows(chip, frames[i]); }))
                << capture_name(capture) << ", frame " << i << ": " << chip.count(0) << "\n"
                << program.errors();
        }
        EXPECT_GT(changes, kFrames / 5) << "sticks that rest show nothing";
    }
    // 25 MHz / 4096 / 50 Hz, less one.
    EXPECT_EQ(chip.prescale(), 121);
    EXPECT_NE(run_shell(TRIBUS_PROGRAM " pwm")
                  .output.find(has_device() ? "outputs that a program has by it cannot be seen"
                                            : "output 15  on"),
              std::string::npos);
    expect_clean_end(program);
    EXPECT_TRUE(all_off(chip)) << "at the end the outputs are off";
}

TEST_F(LabPwm, SwitchesOffWhenTheLinkIsLostAndOnWhenItIsBack) {
    FarEnd& receiver = device("receiver");
    Program& program = run(config());
    const Registers chip(adapter());
    const Sticks sticks(14, 1700);
    Repeater repeater(receiver, ibus_bytes(sticks));
    const auto moves = [&] {
        repeater.send_if_due();
        return shows(chip, sticks);
    };
    ASSERT_TRUE(eventually(moves)) << program.errors();
    EXPECT_TRUE(eventually([&] { return all_off(chip); })) << program.errors();
    EXPECT_TRUE(eventually(moves)) << program.errors();
    expect_clean_end(program);
}

TEST_F(LabPwm, TheChipRepeatsItsLastPulseWhileTheProgramIsStopped) {
    FarEnd& receiver = device("receiver");
    Program& program = run(config());
    const Registers chip(adapter());
    const Sticks sticks(14, 1700);
    Repeater repeater(receiver, ibus_bytes(sticks));
    ASSERT_TRUE(eventually([&] {
        repeater.send_if_due();
        return shows(chip, sticks);
    }));
    program.signal(SIGSTOP);
    shell("sleep 1");
    EXPECT_TRUE(shows(chip, sticks));
    program.signal(SIGCONT);
    EXPECT_TRUE(eventually([&] { return all_off(chip); })) << "the link was lost meanwhile";
    expect_clean_end(program);
}

TEST_F(LabPwm, AfterAKillTheChipRepeatsItsLastPulseUntilItIsSwitchedOff) {
    FarEnd& receiver = device("receiver");
    const std::string file = config();
    Program& program = run(file);
    const Registers chip(adapter());
    const Sticks sticks(14, 1700);
    Repeater repeater(receiver, ibus_bytes(sticks));
    ASSERT_TRUE(eventually([&] {
        repeater.send_if_due();
        return shows(chip, sticks);
    }));
    program.signal(SIGKILL);
    program.end();
    EXPECT_TRUE(shows(chip, sticks)) << "nothing but ExecStopPost ends it";
    // The kernel gives back what a program had by the device, and the driver stops the chip.
    EXPECT_TRUE(eventually([&] { return chip.sleeps() == has_device(); }));
    shell(TRIBUS_PROGRAM " pwm --off " + file);
    EXPECT_TRUE(all_off(chip));
    // The next start takes the outputs as they are.
    Program& next = run(file);
    EXPECT_TRUE(all_off(chip));
    EXPECT_TRUE(eventually([&] {
        repeater.send_if_due();
        return shows(chip, sticks);
    })) << next.errors();
    expect_clean_end(next);
}

TEST_F(LabPwm, TakesOutputsOverThatAnotherProgramTookByTheirFiles) {
    shell("cd /sys/class/pwm/pwmchip*; echo 0 >export; echo 15 >export");
    FarEnd& receiver = device("receiver");
    Program& program = run(config("timeout = \"5s\"\n"));
    const Registers chip(adapter());
    Repeater repeater(receiver, ibus_bytes(Sticks(14, 1700)));
    EXPECT_TRUE(eventually([&] {
        repeater.send_if_due();
        return shows(chip, Sticks(14, 1700));
    })) << program.errors();
    EXPECT_EQ(chip.prescale(), 121);
    expect_clean_end(program);
}

TEST_F(LabPwm, SendsNothingWhereAnotherProgramGaveTheChipAnotherPeriod) {
    shell(
        "cd /sys/class/pwm/pwmchip*; echo 7 >export; cd pwm7; echo 5000000 >period; "
        "echo 1500000 >duty_cycle; echo 1 >enable");
    FarEnd& receiver = device("receiver");
    Program& program = run(config());
    const Registers chip(adapter());
    Repeater repeater(receiver, ibus_bytes(Sticks(14, 1700)));
    EXPECT_TRUE(eventually([&] {
        repeater.send_if_due();
        return program.errors().find("output legs: cannot send") != std::string::npos;
    })) << program.errors();
    EXPECT_TRUE(all_off(chip));
    shell("echo 7 >$(echo /sys/class/pwm/pwmchip*)/unexport");
    EXPECT_TRUE(eventually([&] {
        repeater.send_if_due();
        return shows(chip, Sticks(14, 1700));
    })) << program.errors();
    expect_clean_end(program);
}

TEST_F(LabPwm, OffDoesNotDisturbAProgramThatHasTheOutputsByTheDevice) {
    FarEnd& receiver = device("receiver");
    const std::string file = config("timeout = \"5s\"\n");
    Program& program = run(file);
    const Registers chip(adapter());
    Repeater repeater(receiver, ibus_bytes(Sticks(14, 1700)));
    ASSERT_TRUE(eventually([&] {
        repeater.send_if_due();
        return shows(chip, Sticks(14, 1700));
    })) << program.errors();
    const ShellResult off = run_shell(TRIBUS_PROGRAM " pwm --off " + file);
    EXPECT_EQ(off.status, has_device() ? 1 : 0) << off.output;
    EXPECT_EQ(off.output.find("Device or resource busy") != std::string::npos, has_device());
    EXPECT_EQ(shows(chip, Sticks(14, 1700)), has_device());
    expect_clean_end(program);
}

TEST_F(LabPwm, CorrectsTheOscillator) {
    FarEnd& receiver = device("receiver");
    Program& program = run(config("timeout = \"5s\"\n", "calibration = 1.05\n"));
    const Registers chip(adapter());
    Repeater repeater(receiver, ibus_bytes(Sticks(14, 1500)));
    EXPECT_TRUE(eventually([&] {
        repeater.send_if_due();
        return !chip.is_off(0) && chip.count(0) == count_of_pulse(1575);
    })) << chip.count(0);
    expect_clean_end(program);
}

TEST_F(LabPwm, WaitsForAChipThatIsNotThereYet) {
    FarEnd& receiver = device("receiver");
    write_kernel_file("/sys/bus/i2c/devices/" + adapter() + "/delete_device", "0x40");
    Program& program = run(config());
    EXPECT_TRUE(program.says("there is no such PWM chip")) << program.errors();
    write_kernel_file("/sys/bus/i2c/devices/" + adapter() + "/new_device", "pca9685 0x40");
    Repeater repeater(receiver, ibus_bytes(Sticks(14, 1700)));
    EXPECT_TRUE(eventually([&] {
        repeater.send_if_due();
        return shows(Registers(adapter()), Sticks(14, 1700));
    })) << program.errors();
    expect_clean_end(program);
}

}  // namespace
}  // namespace tribus::test::pwm_pca9685_registers_test
