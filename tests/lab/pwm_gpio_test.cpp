#include <chrono>
#include <csignal>
#include <ctime>
#include <string>

#include <gtest/gtest.h>

#include "tests/lab/gpio_bank.h"
#include "tests/lab/gpio_trace.h"
#include "tests/lab/pca9685.h"
#include "tests/loopback/few_descriptors.h"

/// A PCA9685 with a GPIO line beside it.
namespace tribus::test::pwm_gpio_test {
namespace {

using namespace pca9685;

TEST_F(LabPwm, OutputEnableHasAWaveThatAKillEndsThoughTheChipGoesOn) {
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

TEST_F(LabPwm, WithTooFewDescriptorsTheProgramEndsAndSaysSo) {
    const GpioBank bank{{.names = {{0, "OE"}}}};
    device("receiver");
    const std::string file = config("", "output_enable = \"OE\"\n");
    const DescriptorTrials trials = run_with_few_descriptors(folder(), file);
    EXPECT_GT(trials.ended, 0);
    EXPECT_GT(trials.ran, 0);
}

}  // namespace
}  // namespace tribus::test::pwm_gpio_test
