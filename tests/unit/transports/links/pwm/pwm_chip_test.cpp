#include "transports/links/pwm/pwm_chip.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <filesystem>
#include <initializer_list>
#include <string>

#include <gtest/gtest.h>

#include "app/pwm/pwm.h"
#include "tests/support/pwm_folder.h"
#include "transports/links/unique_fd.h"

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

TEST(PwmChip, ComesByItsNumberAndNothingElseInTheFolderIsOne) {
    PwmFolder folder;
    for (const std::string number : {"10", "2", "9", "1", "30", "3"}) {
        folder.add("pwmchip" + number, "x", 1);
    }
    fs::create_directory(folder.chips() / "pwm-other");
    std::string names;
    for (const PwmChipFacts& chip : find_pwm_chips(folder.root())) {
        names += chip.name + " ";
    }
    EXPECT_EQ(names, "pwmchip1 pwmchip2 pwmchip3 pwmchip9 pwmchip10 pwmchip30 ");
}

TEST(PwmChip, HasAsManyOutputsAsItsFileSaysInDecimal) {
    PwmFolder folder;
    folder.add("pwmchip0", "x", 1);
    PwmFolder::write(folder.chips() / "pwmchip0/npwm", "017\n");
    EXPECT_EQ(find_pwm_chip("x", folder.root())->outputs, 17U);
}

TEST(PwmChip, WithoutADriverIsNamedByItself) {
    PwmFolder folder;
    folder.add("pwmchip0", "x", 1);
    fs::remove(folder.chips() / "pwmchip0/device/driver");
    folder.add("pwmchip1", "y", 1);
    EXPECT_EQ(find_pwm_chip("pwmchip7", folder.root()).error(),
              "pwmchip7: there is no such PWM chip; this machine has pwmchip0, pwmchip1 (y)");
}

TEST(PwmChip, IsHadInThisWayIfThereIsNone) {
    PwmFolder folder;
    EXPECT_EQ(find_pwm_chip("pwmchip0", folder.root()).error(),
              "pwmchip0: there is no such PWM chip; this machine has none now; a device-tree "
              "overlay, such as dtoverlay=i2c-pwm-pca9685a on a Raspberry Pi, makes one");
}

TEST(PwmChip, WhoseDriverHasTwoChipsIsMissing) {
    PwmFolder folder;
    folder.add("pwmchip0", "x", 1);
    EXPECT_FALSE(is_pwm_chip_missing("x", folder.root()));
    folder.add("pwmchip1", "x", 1);
    EXPECT_TRUE(is_pwm_chip_missing("x", folder.root()));
}

/// Files of a chip that are one pipe: what is written into any of them, in its order.
class WrittenInOrder {
  public:
    WrittenInOrder(const PwmFolder& folder, std::initializer_list<const char*> files) {
        const fs::path pipe = folder.root() / "pipe";
        EXPECT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
        reader_ = UniqueFd(::open(pipe.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
        for (const char* file : files) {
            const fs::path path = folder.chips() / "pwmchip0" / file;
            fs::remove(path);
            fs::create_symlink(pipe, path);
        }
    }
    std::string take() const {
        std::string text(1000, ' ');
        const ssize_t size = ::read(reader_.get(), text.data(), text.size());
        text.resize(static_cast<std::size_t>(std::max<ssize_t>(size, 0)));
        return text;
    }

  private:
    UniqueFd reader_;
};

TEST(PwmChip, IsSwitchedOffAndGivenBackBeforeItIsTaken) {
    PwmFolder folder;
    folder.add("pwmchip0", "x", 4);
    const WrittenInOrder written(folder,
                                 {"unexport", "pwm3/enable", "pwm3/duty_cycle", "pwm3/period"});
    PwmOutputs outputs(*find_pwm_chip("pwmchip0", folder.root()), 20ms);
    EXPECT_EQ(outputs.set(3, 1500000), "");
    // Off, given back, off, no pulse, the period; then the pulse, on.
    EXPECT_EQ(written.take(),
              "0"
              "3"
              "0"
              "0"
              "20000000"
              "1500000"
              "1");
    EXPECT_EQ(outputs.set(3, 1600000), "");
    EXPECT_EQ(written.take(), "1600000");
    EXPECT_EQ(outputs.set(3, 0), "");
    EXPECT_EQ(written.take(), "0");
    EXPECT_EQ(outputs.set(3, 0), "");
    EXPECT_EQ(written.take(), "");
    EXPECT_EQ(outputs.set(3, 1600000), "");
    EXPECT_EQ(written.take(),
              "1600000"
              "1");
}

TEST(PwmChip, IsGivenBackAtTheEndOnceItIsOff) {
    PwmFolder folder;
    folder.add("pwmchip0", "x", 4);
    const WrittenInOrder written(folder, {"unexport", "pwm3/enable"});
    {
        PwmOutputs outputs(*find_pwm_chip("pwmchip0", folder.root()), 20ms);
        outputs.set(3, 1500000);
        written.take();
    }
    EXPECT_EQ(written.take(),
              "0"
              "3");
}

TEST(PwmChip, AnOutputThatWasRefusedIsGivenBackAndTakenAnew) {
    PwmFolder folder;
    folder.add("pwmchip0", "x", 4);
    const WrittenInOrder written(folder, {"unexport", "pwm3/enable"});
    const fs::path duty = folder.chips() / "pwmchip0/pwm3/duty_cycle";
    PwmOutputs outputs(*find_pwm_chip("pwmchip0", folder.root()), 20ms);
    EXPECT_EQ(outputs.set(3, 1500000), "");
    written.take();
    fs::remove(duty);
    EXPECT_NE(outputs.set(3, 1600000), "");
    EXPECT_EQ(written.take(), "3");
    PwmFolder::write(duty, "");
    EXPECT_EQ(outputs.set(3, 1600000), "");
    EXPECT_EQ(written.take(),
              "0"
              "3"
              "0"
              "1");
}

TEST(PwmChip, AnOutputWhosePeriodIsRefusedIsGivenBack) {
    PwmFolder folder;
    folder.add("pwmchip0", "x", 4);
    const fs::path period = folder.chips() / "pwmchip0/pwm3/period";
    fs::remove(period);
    const WrittenInOrder written(folder, {"unexport", "pwm3/enable", "pwm3/duty_cycle"});
    PwmOutputs outputs(*find_pwm_chip("pwmchip0", folder.root()), 20ms);
    EXPECT_EQ(outputs.set(3, 1500000), period.string() + ": No such file or directory");
    EXPECT_EQ(written.take(),
              "0"
              "3"
              "0"
              "0"
              "3");
}

/// Here no folder comes when it is asked for.
TEST(PwmChip, AnOutputWithoutItsFolderIsAskedFor) {
    PwmFolder folder;
    folder.add("pwmchip0", "x", 4);
    const fs::path chip = folder.chips() / "pwmchip0";
    fs::remove_all(chip / "pwm3");
    const WrittenInOrder written(folder, {"export", "unexport"});
    PwmOutputs outputs(*find_pwm_chip("pwmchip0", folder.root()), 20ms);
    EXPECT_EQ(outputs.set(3, 1500000),
              (chip / "pwm3/period").string() + ": No such file or directory");
    EXPECT_EQ(written.take(),
              "3"
              "3")
        << "asked for, and given back";
    fs::remove(chip / "export");
    EXPECT_EQ(outputs.set(3, 1500000), (chip / "export").string() + ": No such file or directory");
}

TEST(PwmChip, SaysWhyAFileTookNothing) {
    PwmFolder folder;
    folder.add("pwmchip0", "x", 4);
    const fs::path duty = folder.chips() / "pwmchip0/pwm3/duty_cycle";
    PwmOutputs outputs(*find_pwm_chip("pwmchip0", folder.root()), 20ms);
    fs::remove(duty);
    fs::create_symlink("/dev/full", duty);
    EXPECT_EQ(outputs.set(3, 1500000), duty.string() + ": No space left on device");
}

TEST(PwmChip, HasNoMoreOutputsThanItSaysAndThanThereAreOfAnyChip) {
    PwmFolder folder;
    folder.add("pwmchip0", "x", 4);
    PwmOutputs four(*find_pwm_chip("pwmchip0", folder.root()), 20ms);
    EXPECT_EQ(four.set(3, 1), "");
    EXPECT_EQ(four.set(4, 1), "pwmchip0 has outputs 0 to 3, no 4");
    PwmFolder large;
    large.add("pwmchip0", "x", 70);
    PwmOutputs seventy(*find_pwm_chip("pwmchip0", large.root()), 20ms);
    EXPECT_EQ(seventy.set(63, 1), "");
    EXPECT_NE(seventy.set(64, 1), "");
}

TEST(PwmChip, IsGoneWithItsFolder) {
    PwmFolder folder;
    folder.add("pwmchip0", "x", 1);
    const PwmOutputs outputs(*find_pwm_chip("pwmchip0", folder.root()), 20ms);
    EXPECT_FALSE(outputs.gone());
    fs::remove_all(folder.chips() / "pwmchip0");
    EXPECT_TRUE(outputs.gone());
}

TEST(PwmChip, IsGoneWithItsDevice) {
    PwmFolder folder;
    folder.add("pwmchip0", "x", 1);
    fs::create_directory(folder.root() / "dev");
    const fs::path device = folder.root() / "dev/pwmchip0";
    PwmFolder::write(device, "");
    const PwmOutputs outputs(*find_pwm_chip("pwmchip0", folder.root()), 20ms);
    EXPECT_FALSE(outputs.gone());
    fs::remove(device);
    EXPECT_TRUE(outputs.gone());
}

TEST(PwmOutput, IsSeenWithItsStateIfAProgramHasItByItsFiles) {
    PwmFolder folder;
    folder.add("pwmchip0", "x", 2);
    fs::remove_all(folder.chips() / "pwmchip0/pwm1");
    PwmFolder::write(folder.chips() / "pwmchip0/pwm0/period", "20000000\n");
    PwmFolder::write(folder.chips() / "pwmchip0/pwm0/duty_cycle", "1500000\n");
    PwmFolder::write(folder.chips() / "pwmchip0/pwm0/enable", "1\n");
    const PwmChipFacts chip = *find_pwm_chip("pwmchip0", folder.root());
    const auto seen = look_at(chip, 0);
    ASSERT_TRUE(seen);
    EXPECT_TRUE(seen->on);
    EXPECT_EQ(seen->pulse, 1500us);
    EXPECT_EQ(seen->period, 20ms);
    PwmFolder::write(folder.chips() / "pwmchip0/pwm0/enable", "0\n");
    EXPECT_FALSE(look_at(chip, 0)->on);
    EXPECT_FALSE(look_at(chip, 1)) << "nobody has it";
}

TEST(PwmOutput, ThatWasLeftOnIsSwitchedOffByItsFiles) {
    PwmFolder folder;
    folder.add("pwmchip0", "x", 2);
    fs::create_directory(folder.root() / "dev");
    PwmFolder::write(folder.root() / "dev/pwmchip0", "");
    const PwmChipFacts chip = *find_pwm_chip("pwmchip0", folder.root());
    EXPECT_EQ(switch_off(chip, 1), "");
    EXPECT_EQ(folder.take("pwmchip0", 1, "enable"), "0");
    EXPECT_EQ(folder.take("pwmchip0", 0, "enable"), "");
    fs::remove(folder.chips() / "pwmchip0/pwm1/enable");
    EXPECT_EQ(switch_off(chip, 1),
              (folder.chips() / "pwmchip0/pwm1/enable").string() + ": No such file or directory");
}

TEST(PwmOutput, ThatNobodyHasIsOffWhereTheChipHasNoDevice) {
    PwmFolder folder;
    folder.add("pwmchip0", "x", 2);
    PwmChipFacts chip = *find_pwm_chip("pwmchip0", folder.root());
    EXPECT_EQ(switch_off(chip, 7), "");
    chip.device = folder.root() / "none";
    EXPECT_EQ(switch_off(chip, 7), chip.device.string() + ": No such file or directory");
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
