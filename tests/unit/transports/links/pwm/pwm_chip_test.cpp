#include "transports/links/pwm/pwm_chip.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include "app/pwm/pwm.h"
#include "pipelines/realtime/clock.h"
#include "tests/support/temporary_folder.h"
#include "transports/links/pwm/pwm_link.h"
#include "transports/links/unique_fd.h"

/// PWM chips on a folder with the files of /sys/class/pwm. What the kernel does with them is shown
/// in the laboratory.
namespace tribus::test::pwm_chip_test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

class PwmFolder {
  public:
    /// A chip whose outputs are there already.
    void add(const std::string& name, const std::string& driver, std::size_t outputs) {
        const fs::path chip = chips() / name;
        fs::create_directories(chip / "device");
        fs::create_symlink("../../../bus/drivers/" + driver, chip / "device" / "driver");
        write(chip / "npwm", std::to_string(outputs));
        write(chip / "export", "");
        write(chip / "unexport", "");
        for (std::size_t output = 0; output < outputs; ++output) {
            const fs::path folder = chip / ("pwm" + std::to_string(output));
            fs::create_directories(folder);
            for (const char* file : {"period", "duty_cycle", "enable"}) {
                write(folder / file, "");
            }
        }
    }
    /// The root of all files.
    const fs::path& root() const { return folder_.path(); }
    fs::path chips() const { return root() / "sys/class/pwm"; }
    /// Takes away and returns the text that was written last.
    std::string take(const std::string& chip, std::size_t output, const std::string& file) const {
        const fs::path path = chips() / chip / ("pwm" + std::to_string(output)) / file;
        std::ifstream stream(path);
        std::string text;
        std::getline(stream, text);
        write(path, "");
        return text;
    }
    static void write(const fs::path& path, const std::string& text) {
        std::ofstream(path) << text;
    }

  private:
    TemporaryFolder folder_;
};

TEST(PwmChip, IsFoundByItsNameOrByTheNameOfItsDriver) {
    PwmFolder folder;
    folder.add("pwmchip10", "pca9685-pwm", 16);
    folder.add("pwmchip2", "pwm-bcm2835", 2);
    const auto chips = find_pwm_chips(folder.root());
    ASSERT_EQ(chips.size(), 2U);
    EXPECT_EQ(chips[0].name, "pwmchip2");
    EXPECT_EQ(chips[1].driver, "pca9685-pwm");
    EXPECT_EQ(chips[1].outputs, 16U);
    EXPECT_EQ(find_pwm_chip("pca9685-pwm", folder.root())->name, "pwmchip10");
    EXPECT_EQ(find_pwm_chip("pwmchip2", folder.root())->outputs, 2U);
    EXPECT_EQ(find_pwm_chip("pwmchip0", folder.root()).error(),
              "pwmchip0: there is no such PWM chip; this machine has pwmchip2 (pwm-bcm2835), "
              "pwmchip10 (pca9685-pwm)");
    folder.add("pwmchip3", "pwm-bcm2835", 2);
    EXPECT_EQ(find_pwm_chip("pwm-bcm2835", folder.root()).error(),
              "pwm-bcm2835: several PWM chips have this driver, name one: this machine has "
              "pwmchip2 (pwm-bcm2835), pwmchip3 (pwm-bcm2835)");
    EXPECT_NE(find_pwm_chip("x", folder.root() / "none").error().find("none now"),
              std::string::npos);
}

TEST(PwmChip, IsMissingOnlyWhereTheFolderOfChipsCouldBeRead) {
    PwmFolder folder;
    folder.add("pwmchip2", "pwm-bcm2835", 2);
    EXPECT_TRUE(is_pwm_chip_missing("pwmchip0", folder.root()));
    EXPECT_TRUE(is_pwm_chip_missing("pwmchip0", folder.root() / "none"));
    EXPECT_FALSE(is_pwm_chip_missing("pwmchip2", folder.root()));
    fs::remove_all(folder.chips());
    PwmFolder::write(folder.chips(), "no folder");
    EXPECT_FALSE(is_pwm_chip_missing("pwmchip0", folder.root()));
    EXPECT_EQ(find_pwm_chip("pwmchip0", folder.root()).error(),
              "pwmchip0: " + folder.chips().string() + ": Not a directory");
}

/// The laboratory shows what a kernel's device does (`lab_pwm_device`).
TEST(PwmChip, IsUsedByItsDeviceOnlyWhereThereIsOne) {
    PwmFolder folder;
    folder.add("pwmchip0", "x", 2);
    EXPECT_EQ(find_pwm_chip("pwmchip0", folder.root())->device, fs::path());
    fs::create_directory(folder.root() / "dev");
    const fs::path device = folder.root() / "dev/pwmchip0";
    PwmFolder::write(device, "");
    const auto chip = find_pwm_chip("pwmchip0", folder.root());
    EXPECT_EQ(chip->device, device);
    PwmOutputs outputs(*chip, 20ms);
    const std::string refused = device.string() + " output 1: Inappropriate ioctl for device";
    EXPECT_EQ(outputs.set(1, 1500000), refused);
    EXPECT_EQ(folder.take("pwmchip0", 1, "period"), "") << "its files are left alone";
    EXPECT_EQ(switch_off(*chip, 5), device.string() + " output 5: Inappropriate ioctl for device");
}

TEST(PwmChip, SetsThePeriodBeforeItSwitchesOnAndWritesOnlyWhatChanged) {
    PwmFolder folder;
    folder.add("pwmchip0", "x", 2);
    PwmOutputs outputs(*find_pwm_chip("pwmchip0", folder.root()), 20ms);
    EXPECT_EQ(outputs.set(1, 1500000), "");
    EXPECT_EQ(folder.take("pwmchip0", 1, "period"), "20000000");
    EXPECT_EQ(folder.take("pwmchip0", 1, "duty_cycle"), "1500000");
    EXPECT_EQ(folder.take("pwmchip0", 1, "enable"), "1");
    EXPECT_EQ(outputs.set(1, 1500000), "");
    EXPECT_EQ(folder.take("pwmchip0", 1, "duty_cycle"), "");
    EXPECT_EQ(outputs.set(1, 1600000), "");
    EXPECT_EQ(folder.take("pwmchip0", 1, "duty_cycle"), "1600000");
    EXPECT_EQ(folder.take("pwmchip0", 1, "enable"), "");
    EXPECT_EQ(outputs.set(1, 0), "");
    EXPECT_EQ(folder.take("pwmchip0", 1, "enable"), "0");
    EXPECT_EQ(folder.take("pwmchip0", 1, "duty_cycle"), "");
    EXPECT_EQ(outputs.set(1, 1600000), "");
    EXPECT_EQ(folder.take("pwmchip0", 1, "duty_cycle"), "1600000");
    EXPECT_EQ(folder.take("pwmchip0", 1, "enable"), "1");
    EXPECT_EQ(folder.take("pwmchip0", 0, "enable"), "") << "nobody asked for output 0";
    EXPECT_EQ(outputs.set(2, 1500000), "pwmchip0 has outputs 0 to 1, no 2");
}

TEST(PwmChip, IsSwitchedOffAtTheEnd) {
    PwmFolder folder;
    folder.add("pwmchip0", "x", 2);
    {
        PwmOutputs outputs(*find_pwm_chip("pwmchip0", folder.root()), 20ms);
        outputs.set(0, 1500000);
        folder.take("pwmchip0", 0, "enable");
    }
    EXPECT_EQ(folder.take("pwmchip0", 0, "enable"), "0");
    EXPECT_EQ(folder.take("pwmchip0", 1, "enable"), "");
}

TEST(PwmChip, SaysWhichFileTheKernelRefused) {
    PwmFolder folder;
    folder.add("pwmchip0", "x", 1);
    PwmOutputs outputs(*find_pwm_chip("pwmchip0", folder.root()), 20ms);
    EXPECT_EQ(outputs.set(0, 1500000), "");
    fs::remove(folder.chips() / "pwmchip0/pwm0/duty_cycle");
    EXPECT_EQ(outputs.set(0, 1600000), (folder.chips() / "pwmchip0/pwm0/duty_cycle").string() +
                                           ": No such file or directory");
    PwmFolder::write(folder.chips() / "pwmchip0/pwm0/duty_cycle", "");
    EXPECT_EQ(outputs.set(0, 1600000), "") << "it is tried again";
    EXPECT_EQ(folder.take("pwmchip0", 0, "duty_cycle"), "1600000");
}

/// Waits, at most ten seconds, for the link's own thread.
bool comes(const PwmFolder& folder, std::size_t output, const std::string& file,
           const std::string& wanted) {
    for (int i = 0; i < 1000; ++i) {
        if (folder.take("pwmchip0", output, file) == wanted) {
            return true;
        }
        std::this_thread::sleep_for(10ms);
    }
    return false;
}

TEST(PwmLink, HandsTheNewestPulsesOnAndSwitchesOffAtItsEnd) {
    PwmFolder folder;
    folder.add("pwmchip0", "x", 4);
    auto link = PwmLink::open("pwmchip0", 10ms, {.now = monotonic_now}, folder.root());
    ASSERT_TRUE(link) << link.error();
    // Output 1: 1,500,000 ns; output 3: 1,000,000 ns.
    const std::array<std::uint8_t, 10> frame{1, 0x60, 0xE3, 0x16, 0x00, 3, 0x40, 0x42, 0x0F, 0x00};
    EXPECT_EQ((*link)->write(frame), WriteStatus::written);
    EXPECT_TRUE(comes(folder, 1, "duty_cycle", "1500000"));
    EXPECT_TRUE(comes(folder, 3, "duty_cycle", "1000000"));
    EXPECT_TRUE(comes(folder, 3, "enable", "1"));
    const std::array<std::uint8_t, 5> beyond{4, 0x60, 0xE3, 0x16, 0x00};
    EXPECT_EQ((*link)->write(beyond), WriteStatus::unavailable);
    link->reset();
    EXPECT_EQ(folder.take("pwmchip0", 1, "enable"), "0");
    EXPECT_EQ(folder.take("pwmchip0", 3, "enable"), "0");
    EXPECT_EQ(folder.take("pwmchip0", 0, "enable"), "");
}

/// Output 0: 1,500,000 ns.
constexpr std::array<std::uint8_t, 5> kCentre{0, 0x60, 0xE3, 0x16, 0x00};

/// Waits, at most ten seconds, until the link says that of a frame.
bool says(PwmLink& link, WriteStatus status) {
    for (int i = 0; i < 1000; ++i) {
        if (link.write(kCentre) == status) {
            return true;
        }
        std::this_thread::sleep_for(10ms);
    }
    return false;
}

TEST(PwmLink, SentNothingWhileTheBusOfTheChipHangs) {
    PwmFolder folder;
    folder.add("pwmchip0", "x", 2);
    // A FIFO keeps its writer until somebody reads, as a bus that hangs keeps one.
    const fs::path duty = folder.chips() / "pwmchip0/pwm0/duty_cycle";
    fs::remove(duty);
    ASSERT_EQ(::mkfifo(duty.c_str(), 0600), 0);
    auto link = PwmLink::open("pwmchip0", 20ms, {.now = monotonic_now}, folder.root());
    ASSERT_TRUE(link) << link.error();
    EXPECT_TRUE(says(**link, WriteStatus::unavailable));
    const UniqueFd reader(::open(duty.c_str(), O_RDONLY | O_NONBLOCK));
    EXPECT_TRUE(says(**link, WriteStatus::written));
}

/// The thread was stopped between a request and its work: as after SIGSTOP and SIGCONT.
TEST(PwmLink, HandsNoPulseOnThatIsOlderThanItsPeriodButSwitchesOff) {
    PwmFolder folder;
    folder.add("pwmchip0", "x", 2);
    static std::atomic<Duration> elapsed;
    elapsed = 5s;
    auto link = PwmLink::open("pwmchip0", 20ms, {.now = [] { return Instant(elapsed.load()); }},
                              folder.root());
    ASSERT_TRUE(link) << link.error();
    const auto write = [&](std::span<const std::uint8_t> frame, Duration made) {
        return (*link)->write_asked(frame, {.made = Instant(made), .valid_for = 20ms});
    };
    EXPECT_EQ(write(kCentre, 5s), WriteStatus::written);
    EXPECT_TRUE(comes(folder, 0, "duty_cycle", "1500000"));

    const std::array<std::uint8_t, 5> high{0, 0x80, 0x84, 0x1E, 0x00};  // 2,000,000 ns
    elapsed = 10s;
    write(high, 5s);
    WriteStatus told = WriteStatus::written;
    for (int i = 0; i < 1000 && told == WriteStatus::written; ++i) {
        std::this_thread::sleep_for(10ms);
        told = write(high, 5s);
    }
    EXPECT_EQ(told, WriteStatus::busy) << "a counted drop";
    EXPECT_EQ(folder.take("pwmchip0", 0, "duty_cycle"), "") << "nothing is written";

    const std::array<std::uint8_t, 5> off{0, 0, 0, 0, 0};
    write(off, 5s);
    EXPECT_TRUE(comes(folder, 0, "enable", "0"));
    write(high, 10s);
    EXPECT_TRUE(comes(folder, 0, "duty_cycle", "2000000"));
}

TEST(PwmLink, IsLostWhenTheKernelShowsTheChipNoMore) {
    PwmFolder folder;
    folder.add("pwmchip0", "x", 2);
    auto link = PwmLink::open("pwmchip0", 20ms, {.now = monotonic_now}, folder.root());
    ASSERT_TRUE(link) << link.error();
    fs::remove(folder.chips() / "pwmchip0/pwm0/duty_cycle");
    EXPECT_TRUE(says(**link, WriteStatus::unavailable)) << "one file is refused";
    fs::remove_all(folder.chips() / "pwmchip0");
    EXPECT_TRUE(says(**link, WriteStatus::lost));
}

TEST(PwmLink, IsLostWhenItsDeviceWasRemovedThoughAnotherOneIsThereNow) {
    PwmFolder folder;
    folder.add("pwmchip0", "x", 2);
    fs::create_directory(folder.root() / "dev");
    const fs::path device = folder.root() / "dev/pwmchip0";
    PwmFolder::write(device, "");
    auto link = PwmLink::open("pwmchip0", 20ms, {.now = monotonic_now}, folder.root());
    ASSERT_TRUE(link) << link.error();
    EXPECT_TRUE(says(**link, WriteStatus::unavailable)) << "it takes no pulses";
    fs::remove(device);
    PwmFolder::write(device, "");
    EXPECT_TRUE(says(**link, WriteStatus::lost));
}

TEST(PwmReport, ListsChipsAndTheOutputsInUse) {
    PwmFolder folder;
    EXPECT_NE(pwm_report(folder.root()).find("no PWM chip"), std::string::npos);
    folder.add("pwmchip0", "pca9685-pwm", 2);
    fs::remove_all(folder.chips() / "pwmchip0/pwm1");
    PwmFolder::write(folder.chips() / "pwmchip0/pwm0/period", "20000000\n");
    PwmFolder::write(folder.chips() / "pwmchip0/pwm0/duty_cycle", "1500000\n");
    PwmFolder::write(folder.chips() / "pwmchip0/pwm0/enable", "1\n");
    EXPECT_EQ(pwm_report(folder.root()),
              "pwmchip0  pca9685-pwm, outputs 0 to 1\n"
              "  output  0  on     1500.0 us each 20.000 ms\n");
}

}  // namespace
}  // namespace tribus::test::pwm_chip_test
