#include "transports/links/pwm/pwm_chip.h"

#include <chrono>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "app/pwm/pwm.h"
#include "tests/support/pwm_folder.h"

/// PWM chips on a folder with the files of /sys/class/pwm. What the kernel does with them is shown
/// in the laboratory.
namespace tribus::test::pwm_chip_test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

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
