#include "transports/links/pwm/pwm_device.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "pipelines/realtime/clock.h"
#include "tests/support/fewer_descriptors.h"
#include "tests/support/pwm_device_stand_in.h"
#include "tests/support/pwm_folder.h"
#include "tests/support/seen_within.h"
#include "tests/support/temporary_folder.h"
#include "transports/links/pwm/pwm_chip.h"
#include "transports/links/pwm/pwm_link.h"

/// PWM chips with a device. What a kernel does with it is shown in the laboratory
/// (`lab_pwm_device`).
namespace tribus::test::pwm_device_test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

using Asked = std::vector<std::string>;

class PwmDeviceAsked : public testing::Test {
  protected:
    TemporaryFolder folder_;
    PwmDeviceStandIn kernel_{folder_.path() / "pwmchip0"};
    PwmDevice device_{kernel_.path()};
};

TEST_F(PwmDeviceAsked, TakesAnOutputSetsItsPeriodAndSwitchesItOff) {
    EXPECT_TRUE(device_.is_open());
    EXPECT_EQ(device_.take(3, 20ms), "");
    EXPECT_EQ(kernel_.take(), (Asked{"request 3", "set 3: 0 of 20000000 ns", "set 3: 0 of 0 ns"}));
}

/// As who opened it holds it: its mode, and whether programs that are started have it too.
TEST_F(PwmDeviceAsked, IsOpenForBothDirectionsAndForThisProgramAlone) {
    struct stat wanted {};
    ASSERT_EQ(::stat(kernel_.path().c_str(), &wanted), 0);
    int found = 0;
    for (int descriptor = 0; descriptor < 200; ++descriptor) {
        struct stat facts {};
        if (::fstat(descriptor, &facts) == 0 && facts.st_ino == wanted.st_ino &&
            facts.st_dev == wanted.st_dev) {
            ++found;
            EXPECT_EQ(::fcntl(descriptor, F_GETFL) & O_ACCMODE, O_RDWR);
            EXPECT_EQ(::fcntl(descriptor, F_GETFD), FD_CLOEXEC);
        }
    }
    EXPECT_EQ(found, 1);
}

TEST_F(PwmDeviceAsked, GivesAnOutputBack) {
    device_.give_back(3);
    EXPECT_EQ(kernel_.take(), Asked{"free 3"});
}

TEST_F(PwmDeviceAsked, SetsAPulseOnceItKnowsThePeriodThatComesOfIt) {
    EXPECT_EQ(device_.set(3, 20ms, 1500000), "");
    EXPECT_EQ(kernel_.take(),
              (Asked{"round 3: 1500000 of 20000000 ns", "set 3: 1500000 of 20000000 ns"}));
}

TEST_F(PwmDeviceAsked, SwitchesAnOutputOff) {
    EXPECT_EQ(device_.switch_off(3), "");
    EXPECT_EQ(kernel_.take(), Asked{"set 3: 0 of 0 ns"});
}

struct Period {
    std::uint64_t made;
    bool good;
};

class PwmPeriod : public PwmDeviceAsked, public testing::WithParamInterface<Period> {};

TEST_P(PwmPeriod, MayBeATwentiethOff) {
    kernel_.make_period(GetParam().made);
    const std::string wrong = kernel_.path() + " output 3: the chip makes a period of " +
                              std::to_string(GetParam().made) +
                              " ns of 20000000 ns; another program may have set it";
    EXPECT_EQ(device_.set(3, 20ms, 1500000), GetParam().good ? "" : wrong);
    const Asked rounded{"round 3: 1500000 of 20000000 ns"};
    const Asked set{rounded[0], "set 3: 1500000 of 20000000 ns"};
    EXPECT_EQ(kernel_.take(), GetParam().good ? set : rounded);
}

INSTANTIATE_TEST_SUITE_P(Each, PwmPeriod,
                         testing::Values(Period{19'999'999, true}, Period{19'000'000, true},
                                         Period{18'999'999, false}, Period{21'000'000, true},
                                         Period{21'000'001, false}, Period{0, false}));

TEST_F(PwmDeviceAsked, TellsWhatTheKernelRefuses) {
    const std::string output = kernel_.path() + " output 3: ";
    kernel_.refuse("set 3: 0 of 0", EIO);
    EXPECT_EQ(device_.switch_off(3), output + "Input/output error");
    EXPECT_EQ(device_.take(3, 20ms), output + "Input/output error");
    kernel_.refuse("set 3: 0 of 20000000", EINVAL);
    EXPECT_EQ(device_.take(3, 20ms), output + "Invalid argument");
    kernel_.take();
    kernel_.refuse("request 3", EBUSY);
    EXPECT_EQ(device_.take(3, 20ms), output + "Device or resource busy");
    EXPECT_EQ(kernel_.take(), Asked{}) << "nothing of an output that others have is set";
    kernel_.refuse("set 3: 1500000", ENODEV);
    EXPECT_EQ(device_.set(3, 20ms, 1500000), output + "No such device");
    kernel_.take();
    kernel_.refuse("round 3", ENOTTY);
    EXPECT_EQ(device_.set(3, 20ms, 1500000), output + "Inappropriate ioctl for device");
    EXPECT_EQ(kernel_.take(), Asked{});
}

TEST_F(PwmDeviceAsked, IsGoneOnceItWasRemoved) {
    EXPECT_FALSE(device_.gone());
    fs::remove(kernel_.path());
    EXPECT_TRUE(device_.gone());
}

TEST_F(PwmDeviceAsked, ThatIsNotThereIsNeitherOpenNorGone) {
    for (const fs::path& path : {fs::path(), folder_.path() / "none"}) {
        const PwmDevice none(path);
        EXPECT_FALSE(none.is_open()) << path;
        EXPECT_FALSE(none.gone()) << path;
    }
}

class PwmChipWithADevice : public testing::Test {
  protected:
    PwmChipWithADevice() {
        folder_.add("pwmchip0", "x", 4);
        for (const char* output : {"pwm0", "pwm1", "pwm2", "pwm3"}) {
            fs::remove_all(folder_.chips() / "pwmchip0" / output);
        }
    }
    PwmChipFacts chip() const { return *find_pwm_chip("pwmchip0", folder_.root()); }

    PwmFolder folder_;
    PwmDeviceStandIn kernel_{folder_.root() / "dev/pwmchip0"};
};

TEST_F(PwmChipWithADevice, TakesAnOutputOnceAndSetsWhatChanged) {
    PwmOutputs outputs(chip(), 20ms);
    EXPECT_EQ(outputs.set(3, 1500000), "");
    EXPECT_EQ(kernel_.take(),
              (Asked{"request 3", "set 3: 0 of 20000000 ns", "set 3: 0 of 0 ns",
                     "round 3: 1500000 of 20000000 ns", "set 3: 1500000 of 20000000 ns"}));
    EXPECT_EQ(outputs.set(3, 1500000), "");
    EXPECT_EQ(kernel_.take(), Asked{});
    EXPECT_EQ(outputs.set(3, 1), "");
    EXPECT_EQ(kernel_.take(), (Asked{"round 3: 1 of 20000000 ns", "set 3: 1 of 20000000 ns"}));
    EXPECT_EQ(outputs.set(3, 0), "");
    EXPECT_EQ(kernel_.take(), Asked{"set 3: 0 of 0 ns"});
}

TEST_F(PwmChipWithADevice, SwitchesOffAndGivesBackWhatItTookAtItsEnd) {
    {
        PwmOutputs outputs(chip(), 20ms);
        outputs.set(0, 1500000);
        outputs.set(3, 0);
        kernel_.take();
    }
    EXPECT_EQ(kernel_.take(), (Asked{"set 0: 0 of 0 ns", "free 0", "free 3"}));
}

TEST_F(PwmChipWithADevice, GivesBackWhatItCannotHaveOrSet) {
    PwmOutputs outputs(chip(), 20ms);
    kernel_.refuse("set 3: 0 of 20000000", EINVAL);
    EXPECT_EQ(outputs.set(3, 1500000), kernel_.path() + " output 3: Invalid argument");
    EXPECT_EQ(kernel_.take(), (Asked{"request 3", "free 3"}));
    kernel_.refuse("set 1: 1600000", EIO);
    EXPECT_EQ(outputs.set(1, 1500000), "");
    kernel_.take();
    EXPECT_EQ(outputs.set(1, 1600000), kernel_.path() + " output 1: Input/output error");
    EXPECT_EQ(kernel_.take(), (Asked{"round 1: 1600000 of 20000000 ns", "free 1"}));
}

TEST_F(PwmChipWithADevice, TakesAnOutputFromWhoHadItByItsFiles) {
    folder_.add_output("pwmchip0", 3);
    PwmOutputs outputs(chip(), 20ms);
    EXPECT_EQ(outputs.set(3, 1500000), "");
    EXPECT_EQ(folder_.take("pwmchip0", 3, "enable"), "0");
    EXPECT_EQ(folder_.read("pwmchip0", "unexport"), "3");
    EXPECT_EQ(folder_.read("pwmchip0", "export"), "");
}

TEST_F(PwmChipWithADevice, SwitchesOffAnOutputThatWasLeftOn) {
    EXPECT_EQ(switch_off(chip(), 2), "");
    EXPECT_EQ(kernel_.take(),
              (Asked{"request 2", "set 2: 0 of 20000000 ns", "set 2: 0 of 0 ns", "free 2"}));
    kernel_.refuse("request 2", EBUSY);
    EXPECT_EQ(switch_off(chip(), 2), kernel_.path() + " output 2: Device or resource busy");
}

/// Output 0: 1,500,000 ns; output 3 too.
constexpr std::array<std::uint8_t, 10> kBoth{0, 0x60, 0xE3, 0x16, 0x00, 3, 0x60, 0xE3, 0x16, 0x00};

TEST_F(PwmChipWithADevice, IsToldToBeLostThoughAnotherOutputIsKept) {
    auto link = PwmLink::open("pwmchip0", 20ms, {.now = monotonic_now}, folder_.root());
    ASSERT_TRUE(link) << link.error();
    const auto says = [&](WriteStatus status) {
        return seen_within([&] { return (*link)->write(kBoth) == status; });
    };
    EXPECT_TRUE(says(WriteStatus::written));
    kernel_.refuse("request 0", ENODEV);
    kernel_.refuse("round 0", ENODEV);
    kernel_.keep("round 3");
    fs::remove(kernel_.path());
    std::array<std::uint8_t, 10> others = kBoth;
    others[1] = others[6] = 0x61;
    EXPECT_TRUE(seen_within([&] { return (*link)->write(others) == WriteStatus::lost; }));
    kernel_.go_on();
}

TEST_F(PwmChipWithADevice, IsNotOpenedWhereItsThreadHasNoDescriptor) {
    const FewerDescriptors one(1);
    const auto link = PwmLink::open("pwmchip0", 20ms, {.now = monotonic_now}, folder_.root());
    ASSERT_FALSE(link);
    EXPECT_EQ(link.error(), "pwmchip0: Too many open files");
}

/// Its files are of no use then.
TEST_F(PwmChipWithADevice, IsOpenedWithoutTheFileThatGivesOutputs) {
    fs::remove(folder_.chips() / "pwmchip0/export");
    EXPECT_TRUE(PwmLink::open("pwmchip0", 20ms, {.now = monotonic_now}, folder_.root()));
}

}  // namespace
}  // namespace tribus::test::pwm_device_test
