#include <fcntl.h>
#include <linux/i2c-dev.h>
#include <linux/i2c.h>
#include <sys/ioctl.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <ctime>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/lab/gpio_bank.h"
#include "tests/lab/gpio_trace.h"
#include "tests/lab/guest.h"
#include "tests/lab/recorded_receiver.h"
#include "tests/loopback/few_descriptors.h"
#include "tests/loopback/loopback.h"
#include "transports/links/unique_fd.h"

/// The built program on the kernel's driver for the PCA9685, whose chip is a bank of registers in
/// memory (i2c-stub): what the driver wrote there is what would come out of the chip.
namespace tribus::test::pwm_pca9685_test {
namespace {

constexpr int kAddress = 0x40;

/// The registers of the chip, read past the driver.
class Registers {
  public:
    explicit Registers(const std::string& adapter)
        : fd_(::open(("/dev/" + adapter).c_str(), O_RDWR | O_CLOEXEC)) {
        EXPECT_TRUE(fd_.valid()) << adapter;
        EXPECT_EQ(::ioctl(fd_.get(), I2C_SLAVE_FORCE, kAddress), 0);
    }
    int at(int number) const {
        i2c_smbus_data data{};
        i2c_smbus_ioctl_data request{.read_write = I2C_SMBUS_READ,
                                     .command = static_cast<std::uint8_t>(number),
                                     .size = I2C_SMBUS_BYTE_DATA,
                                     .data = &data};
        EXPECT_GE(::ioctl(fd_.get(), I2C_SMBUS, &request), 0) << number;
        return data.byte;
    }
    // Data sheet of the PCA9685, 7.3.3 and 7.3.5: four registers an output, on and off, each a
    // count from 0 to 4095; bit 4 of the high byte of "off" switches the output off.
    bool is_off(int output) const { return (at(9 + 4 * output) & 0x10) != 0; }
    int count(int output) const {
        const int on = at(6 + 4 * output) | (at(7 + 4 * output) & 0x0F) << 8;
        const int off = at(8 + 4 * output) | (at(9 + 4 * output) & 0x0F) << 8;
        return (off - on + 4096) % 4096;
    }
    int prescale() const { return at(0xFE); }
    // 7.3.1: the oscillator stands still.
    bool sleeps() const { return (at(0) & 0x10) != 0; }

  private:
    UniqueFd fd_;
};

class LabPwm : public Loopback {
  protected:
    LabPwm() {
        require_guest();
        shell("modprobe i2c-dev; modprobe i2c-stub chip_addr=0x40; modprobe pwm-pca9685");
        for (const auto& entry : std::filesystem::directory_iterator("/sys/bus/i2c/devices")) {
            if (read_file(entry.path() / "name").starts_with("SMBus stub driver")) {
                adapter_ = entry.path().filename();
            }
        }
        write_kernel_file("/sys/bus/i2c/devices/" + adapter_ + "/new_device", "pca9685 0x40");
    }
    ~LabPwm() override {
        write_kernel_file("/sys/bus/i2c/devices/" + adapter_ + "/delete_device", "0x40");
        shell("rmmod pwm-pca9685; rmmod i2c-stub");
    }
    std::string config(const std::string& input = "", const std::string& output = "") {
        return write_config("[input.receiver]\nprotocol = \"ibus\"\ndevice = \"@receiver\"\n" +
                            input + "[output.legs]\nprotocol = \"pwm\"\nchip = \"pca9685-pwm\"\n" +
                            "outputs = { 1 = 0, 2 = 1, 3 = 4, 4 = 15 }\n" + output +
                            "[pipeline.main]\nfrom = \"receiver\"\nto = \"legs\"\n"
                            "[pipeline.main.failsafe]\nhold = \"0s\"\nrecover = \"0s\"\n");
    }
    const std::string& adapter() const { return adapter_; }

  private:
    std::string adapter_;
};

constexpr std::array kOutputs{0, 1, 4, 15};
constexpr std::size_t kFrames = 400;

/// The channels that the chip gets.
Sticks sent(const Sticks& sticks) {
    return {sticks.begin(), sticks.begin() + kOutputs.size()};
}

/// Linux 6.17 and later have it.
bool has_device() {
    return std::filesystem::exists("/dev/pwmchip0");
}

/// The count for a pulse of a period of 20 ms. The driver of before rounds up; the one that came
/// with the device rounds down, to 122 * 40 ns.
int count_of_pulse(int microseconds) {
    return has_device() ? 1000 * microseconds / 4880 : (4096 * microseconds + 19999) / 20000;
}

bool shows(const Registers& chip, const Sticks& sticks) {
    for (std::size_t i = 0; i < kOutputs.size(); ++i) {
        if (chip.is_off(kOutputs[i]) || chip.count(kOutputs[i]) != count_of_pulse(sticks[i])) {
            return false;
        }
    }
    return true;
}

bool all_off(const Registers& chip) {
    return std::ranges::all_of(kOutputs, [&](int output) { return chip.is_off(output); });
}

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
    const std::vector<Sticks> frames = recorded_sticks();
    ASSERT_GE(frames.size(), kFrames);
    std::size_t changes = 0;
    for (std::size_t i = 0; i < kFrames; ++i) {
        changes += i > 0 && sent(frames[i]) != sent(frames[i - 1]) ? 1U : 0U;
        receiver.send(ibus_bytes(frames[i]));
        ASSERT_TRUE(eventually([&] { return shows(chip, frames[i]); }))
            << "frame " << i << ": " << chip.count(0) << "\n"
            << program.errors();
    }
    EXPECT_GT(changes, kFrames / 5) << "sticks that rest show nothing";
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

/// With GPIO lines of the first version of the kernel's interface, for which the program is built
/// beside Debian 12: newer kernels of Debian lack it.
class LabPwmWithGpio : public LabPwm {
  protected:
    void SetUp() override {
        if (has_device()) {
            GTEST_SKIP() << "the kernel lacks version 1 of the GPIO interface";
        }
    }
};

TEST_F(LabPwmWithGpio, OutputEnableHasAWaveThatAKillEndsThoughTheChipGoesOn) {
    const GpioBank bank{{.names = {{0, "OE"}}}};
    const LevelTrace trace;
    FarEnd& receiver = device("receiver");
    Program& program = run(config("timeout = \"5s\"\n", "output_enable = \"OE\"\n"));
    const Registers chip(adapter());
    const Sticks sticks(14, 1700);
    EXPECT_TRUE(trace.edges().empty()) << "before the first frame";
    Repeater repeater(receiver, ibus_bytes(sticks));
    ASSERT_TRUE(eventually([&] {
        repeater.send_if_due();
        return trace.edges().size() >= 10 && shows(chip, sticks);
    })) << program.errors();
    program.signal(SIGKILL);
    const auto killed = std::chrono::steady_clock::now();
    program.end();
    // 20 periods of the wave, four times the 20 ms of the output.
    const timespec pause{.tv_sec = 1, .tv_nsec = 600'000'000};
    ::nanosleep(&pause, nullptr);
    EXPECT_LE(trace.edges_after(killed), 4U);
    EXPECT_TRUE(shows(chip, sticks));
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

TEST_F(LabPwmWithGpio, WithTooFewDescriptorsTheProgramEndsAndSaysSo) {
    const GpioBank bank{{.names = {{0, "OE"}}}};
    device("receiver");
    const std::string file = config("", "output_enable = \"OE\"\n");
    const DescriptorTrials trials = run_with_few_descriptors(folder(), file);
    EXPECT_GT(trials.ended, 0);
    EXPECT_GT(trials.ran, 0);
}

}  // namespace
}  // namespace tribus::test::pwm_pca9685_test
