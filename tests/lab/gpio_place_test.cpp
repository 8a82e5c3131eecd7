#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/lab/gpio_bank.h"
#include "transports/links/gpio/gpio_line.h"

/// How a line is found, and the messages if it cannot be opened.
namespace tribus::test::gpio_place_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

std::string error_of(const GpioPlace& place) {
    const auto output = GpioOutput::open(place, false, true);
    return output ? "" : output.error();
}

TEST(GpioLibrary, IsOfTheVersionThatTheseTestsAreBuiltFor) {
    std::ifstream maps("/proc/self/maps");
    const std::string loaded{std::istreambuf_iterator<char>(maps), {}};
    for (const std::string library : {"libgpiod.so.2", "libgpiod.so.3"}) {
        EXPECT_EQ(loaded.find(library) != std::string::npos, library == TRIBUS_GPIO_LIBRARY)
            << library;
    }
}

TEST(GpioPlaceInTheLab, IsAnOffsetOnAChipByNameOrPath) {
    const GpioBank bank;
    EXPECT_EQ(error_of({bank.chip(), 7U}), "");
    EXPECT_EQ(error_of({bank.path(), 7U}), "");
}

TEST(GpioPlaceInTheLab, IsFoundThroughASymbolicLinkThatCountsAsNoChipOfItsOwn) {
    const GpioBank bank({.names = {{4, "VALVE"}}});
    std::filesystem::remove("/dev/gpiochip77");
    std::filesystem::create_symlink(bank.chip(), "/dev/gpiochip77");
    EXPECT_EQ(error_of({"gpiochip77", 7U}), "");
    EXPECT_EQ(error_of({"", "VALVE"}), "");
    std::filesystem::remove("/dev/gpiochip77");
}

TEST(GpioPlaceInTheLab, IsANameOnAChip) {
    const GpioBank bank({.names = {{4, "VALVE"}}});
    const auto output = GpioOutput::open({bank.chip(), "VALVE"}, false, true);
    ASSERT_TRUE(output) << output.error();
    EXPECT_EQ(bank.level(4), "1");
    EXPECT_EQ(bank.level(3), "0");
}

TEST(GpioPlaceInTheLab, IsANameOnAnyChip) {
    const GpioBank first({.name = "first", .names = {{4, "VALVE"}}});
    const GpioBank second({.name = "second", .names = {{6, "LAMP"}}});
    const auto output = GpioOutput::open({"", "LAMP"}, false, true);
    ASSERT_TRUE(output) << output.error();
    EXPECT_EQ(second.level(6), "1");
    EXPECT_EQ(first.level(6), "0");
}

TEST(GpioErrors, NameThePlacesOfANameThatIsThereTwice) {
    const GpioBank first({.name = "first", .names = {{4, "LAMP"}}});
    const GpioBank second({.name = "second", .names = {{6, "LAMP"}}});
    EXPECT_EQ(error_of({"", "LAMP"}), "LAMP: 2 lines have this name; give one of " + first.chip() +
                                          ":4, " + second.chip() + ":6");
    EXPECT_EQ(error_of({second.chip(), "LAMP"}), "");
}

TEST(GpioErrors, OfferTheNamesThatAreThere) {
    const GpioBank bank({.names = {{4, "VALVE"}, {6, "LAMP"}}});
    EXPECT_EQ(error_of({bank.chip(), "LAMPE"}),
              bank.chip() + ":LAMPE: no line of " + bank.chip() +
                  " has the name \"LAMPE\"; the names are: \"LAMP\", \"VALVE\"");
}

TEST(GpioErrors, SayHowManyLinesThereAre) {
    const GpioBank bank;
    EXPECT_EQ(error_of({bank.chip(), 8U}),
              bank.chip() + ":8: this chip has 8 lines: give an offset from 0 to 7");
}

TEST(GpioErrors, SayWhichChipsThereAre) {
    const GpioBank bank;
    for (const std::string chip : {"gpiochip99", "/dev/null", "/dev/ttyS0", "/etc/passwd", "/"}) {
        EXPECT_EQ(error_of({chip, 1U}), chip + ":1: there is no such GPIO chip; this machine has " +
                                            bank.chip() +
                                            "; `gpiodetect` (package gpiod) describes them");
    }
}

TEST(GpioErrors, SayThatThereAreNoChips) {
    for (const GpioPlace& place : {GpioPlace{"", "LAMP"}, GpioPlace{"gpiochip0", 1U}}) {
        EXPECT_THAT(error_of(place), HasSubstr("this machine has no GPIO chips"));
    }
}

TEST(GpioErrors, SayWhichProgramHasTheLine) {
    const GpioBank bank;
    const auto holder = GpioInput::open({bank.chip(), 1U}, false, GpioBias::as_is);
    ASSERT_TRUE(holder) << holder.error();
    EXPECT_THAT(error_of({bank.chip(), 1U}),
                StartsWith(bank.chip() + ":1: it is in use by \"tribus\", a program,"));
    const auto second = GpioInput::open({bank.chip(), 1U}, false, GpioBias::pull_up);
    ASSERT_FALSE(second);
    EXPECT_THAT(second.error(), HasSubstr("it is in use by \"tribus\""));
}

TEST(GpioErrors, SayThatTheKernelKeepsTheLine) {
    const GpioBank bank({.hogged = 2});
    EXPECT_THAT(error_of({bank.chip(), 2U}), HasSubstr("in use by \"lab-hog\""));
}

TEST(GpioErrors, SayHowToGetThePermission) {
    const GpioBank bank({.names = {{4, "LAMP"}}});
    ASSERT_EQ(::seteuid(65534), 0);
    const std::string by_offset = error_of({bank.chip(), 1U});
    const std::string by_name = error_of({"", "LAMP"});
    ASSERT_EQ(::seteuid(0), 0);
    EXPECT_THAT(by_offset, AllOf(StartsWith(bank.chip() + ":1: no permission to open it"),
                                 HasSubstr("/etc/udev/rules.d/60-gpio.rules")));
    EXPECT_THAT(by_name, StartsWith("LAMP: " + bank.chip() + ": no permission to open it"));
}

}  // namespace
}  // namespace tribus::test::gpio_place_test
