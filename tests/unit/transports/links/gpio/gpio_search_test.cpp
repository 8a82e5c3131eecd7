#include "transports/links/gpio/gpio_search.h"

#include <cerrno>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

namespace tribus::gpio_search_test {
namespace {

/// Returns a chip with these line names.
GpioChip chip(const std::string& path, const std::vector<std::string>& names) {
    GpioChip chip{path, 0, {}};
    for (const std::string& name : names) {
        chip.lines.push_back({name, false, ""});
    }
    return chip;
}

std::string error_of(const GpioPlace& place, const std::vector<GpioChip>& chips) {
    const auto found = find_gpio_line(place, place.chip.empty() ? "" : chip_path(place), chips);
    return found ? "" : found.error();
}

const std::vector<GpioChip> kBoard{chip("/dev/gpiochip0", {"GPIO0", "GPIO1", "GPIO2"}),
                                   chip("/dev/gpiochip1", {"", "BT_ON"})};

TEST(GpioSearchTest, FindsAnOffset) {
    const auto found = find_gpio_line({"gpiochip1", 1U}, "/dev/gpiochip1", kBoard);
    ASSERT_TRUE(found) << found.error();
    EXPECT_EQ(&found->chip, &kBoard[1]);
    EXPECT_EQ(found->offset, 1U);
}

TEST(GpioSearchTest, FindsANameOnAnyChip) {
    const auto found = find_gpio_line({"", "BT_ON"}, "", kBoard);
    ASSERT_TRUE(found) << found.error();
    EXPECT_EQ(&found->chip, &kBoard[1]);
    EXPECT_EQ(found->offset, 1U);
}

TEST(GpioSearchTest, FindsANameOnTheNamedChipOnly) {
    EXPECT_EQ(error_of({"gpiochip0", "BT_ON"}, kBoard),
              "no line of gpiochip0 has the name \"BT_ON\"; the names are: \"GPIO0\", \"GPIO1\", "
              "\"GPIO2\"");
}

TEST(GpioSearchTest, TakesAFoundNameAlthoughAnotherChipIsNotKnown) {
    const std::vector<GpioChip> chips{{"/dev/gpiochip0", EACCES, {}}, kBoard[1]};
    EXPECT_EQ(error_of({"", "BT_ON"}, chips), "");
}

TEST(GpioSearchTest, SaysThatTheMachineHasNoChips) {
    EXPECT_EQ(
        error_of({"gpiochip0", 1U}, {}),
        "this machine has no GPIO chips (/dev/gpiochip*): no driver for one is loaded, or its "
        "kernel is built without CONFIG_GPIO_CDEV");
}

TEST(GpioSearchTest, SaysWhichChipsThereAre) {
    EXPECT_EQ(error_of({"gpiochip2", 1U}, kBoard),
              "there is no such GPIO chip; this machine has gpiochip0, gpiochip1; `gpiodetect` "
              "(package gpiod) describes them");
}

TEST(GpioSearchTest, SaysWhichOffsetsThereAre) {
    EXPECT_EQ(error_of({"gpiochip0", 3U}, kBoard),
              "this chip has 3 lines: give an offset from 0 to 2");
    EXPECT_EQ(error_of({"gpiochip0", 0U}, {chip("/dev/gpiochip0", {})}), "this chip has no lines");
}

TEST(GpioSearchTest, SaysThatAnOffsetTakesAChip) {
    EXPECT_EQ(error_of({"", 3U}, kBoard), "an offset needs a chip, such as gpiochip0:3");
}

TEST(GpioSearchTest, OffersTheNamesThatBeginMostAlikeFirst) {
    const std::vector<GpioChip> chips{
        chip("/dev/gpiochip0", {"ID_SD", "GPIO1", "GPIO2", "GPIO17", "", "GPIO18", "GPIO3", "X"})};
    EXPECT_EQ(
        error_of({"", "gpio177"}, chips),
        "no line of gpiochip0 has the name \"gpio177\"; the names are: \"GPIO17\", \"GPIO1\", "
        "\"GPIO18\", \"GPIO2\", \"GPIO3\", \"ID_SD\" and more, which `gpioinfo` (package "
        "gpiod) shows");
}

TEST(GpioSearchTest, NamesSixLinesWithoutSayingThatThereAreMore) {
    EXPECT_EQ(error_of({"", "X"}, {chip("/dev/gpiochip0", {"A", "B", "C", "D", "E", "F"})}),
              "no line of gpiochip0 has the name \"X\"; the names are: \"A\", \"B\", \"C\", "
              "\"D\", \"E\", \"F\"");
}

TEST(GpioSearchTest, TellsOfTheFirstOfChipsThatAreAllUnknown) {
    const std::vector<GpioChip> chips{{"/dev/gpiochip0", ENODEV, {}},
                                      {"/dev/gpiochip1", EPERM, {}}};
    EXPECT_EQ(error_of({"", "LAMP"}, chips), "gpiochip0, gpiochip1: it has just been removed");
    EXPECT_EQ(error_of({"gpiochip0", 1U}, {{"/dev/gpiochip0", ENOMEM, {}}}),
              "the kernel does not describe its lines: Cannot allocate memory");
}

TEST(GpioSearchTest, SaysThatNoLineHasAName) {
    EXPECT_EQ(error_of({"", "LAMP"}, {chip("/dev/gpiochip3", {"", ""})}),
              "no line of gpiochip3 has the name \"LAMP\"; no line has a name: give chip and "
              "offset, such as gpiochip3:0");
}

TEST(GpioSearchTest, SaysWhereANameIsThereTwice) {
    EXPECT_EQ(error_of({"", "A"},
                       {chip("/dev/gpiochip0", {"A", "B", "A"}), chip("/dev/gpiochip1", {"A"})}),
              "3 lines have this name; give one of gpiochip0:0, gpiochip0:2, gpiochip1:0");
}

TEST(GpioSearchTest, SaysWhichTwoLinesHaveAName) {
    EXPECT_EQ(error_of({"", "A"}, {chip("/dev/gpiochip0", {"B", "A", "A"})}),
              "2 lines have this name; give one of gpiochip0:1, gpiochip0:2");
}

TEST(GpioSearchTest, SaysHowToGetThePermission) {
    const std::vector<GpioChip> chips{{"/dev/gpiochip0", EACCES, {}}};
    const std::string permission =
        "no permission to open it; GPIO chips belong to root alone unless a rule says otherwise: "
        "put SUBSYSTEM==\"gpio\", KERNEL==\"gpiochip*\", GROUP=\"gpio\", MODE=\"0660\" into "
        "/etc/udev/rules.d/60-gpio.rules, then `sudo groupadd --system gpio; sudo usermod -aG gpio "
        "$USER; sudo udevadm trigger`, and log in again";
    EXPECT_EQ(error_of({"gpiochip0", 1U}, chips), permission);
    EXPECT_EQ(error_of({"", "LAMP"}, chips), "gpiochip0: " + permission);
}

TEST(GpioSearchTest, SaysWhyANameMayBeOnAnotherChip) {
    const std::vector<GpioChip> chips{kBoard[1], {"/dev/gpiochip7", EPERM, {}}};
    EXPECT_EQ(error_of({"", "LAMP"}, chips),
              "no line of gpiochip1, gpiochip7 has the name \"LAMP\"; the names are: \"BT_ON\"; "
              "the lines of gpiochip7 are unknown: this program may not open any GPIO chip, not "
              "even as root; does its service's unit lack `DeviceAllow=char-gpiochip rw`?");
}

TEST(GpioSearchTest, SaysWhichKernelItTakes) {
    EXPECT_EQ(error_of({"gpiochip0", 1U}, {{"/dev/gpiochip0", EINVAL, {}}}),
              "the kernel lacks the GPIO interface that this program is built for: version 2 of "
              "libgpiod needs Linux 5.10 or newer, version 1 needs CONFIG_GPIO_CDEV_V1");
}

struct Refusal {
    int error;
    GpioLineFacts line;
    GpioUse use;
    GpioBias bias;
    std::string_view sentence;
};

class GpioRefusalTest : public testing::TestWithParam<Refusal> {};

TEST_P(GpioRefusalTest, SaysWhatToDo) {
    const Refusal& refusal = GetParam();
    EXPECT_EQ(gpio_refusal(refusal.error, refusal.line, refusal.use, refusal.bias),
              refusal.sentence);
}

constexpr std::string_view kInUseByNobodyKnown =
    "it is in use, the kernel does not say by what: another program, a driver, or another "
    "function of this pin (UART, SPI, ...); free it, or use another line";

constexpr std::string_view kKernelLacksIt =
    "the kernel lacks the GPIO interface that this program is built for: version 2 of libgpiod "
    "needs Linux 5.10 or newer, version 1 needs CONFIG_GPIO_CDEV_V1";

// 524 is ENOTSUPP of the kernel's include/linux/errno.h.
INSTANTIATE_TEST_SUITE_P(
    Errors, GpioRefusalTest,
    testing::Values(
        Refusal{EBUSY,
                {"", true, "gpioset"},
                GpioUse::output,
                GpioBias::as_is,
                "it is in use by \"gpioset\", a program, a driver or the device tree: end that, or "
                "use another line"},
        Refusal{EBUSY, {"", false, ""}, GpioUse::output, GpioBias::as_is, kInUseByNobodyKnown},
        Refusal{EINVAL, {"", true, ""}, GpioUse::output, GpioBias::as_is, kInUseByNobodyKnown},
        Refusal{EINVAL,
                {},
                GpioUse::input,
                GpioBias::pull_up,
                "the kernel refuses a bias for it: that needs Linux 5.5 or newer and a chip with "
                "such resistors; set no bias, and connect a resistor to the line"},
        Refusal{ENXIO,
                {},
                GpioUse::input,
                GpioBias::as_is,
                "its chip does not report changes of this line (it has no interrupt), or is gone; "
                "use a line of another chip"},
        Refusal{ENODEV,
                {},
                GpioUse::input,
                GpioBias::as_is,
                "its chip does not report changes of this line (it has no interrupt), or is gone; "
                "use a line of another chip"},
        Refusal{ENODEV, {}, GpioUse::output, GpioBias::as_is, "it has just been removed"},
        Refusal{ENXIO, {}, GpioUse::output, GpioBias::as_is, "it has just been removed"},
        Refusal{ENOENT, {}, GpioUse::input, GpioBias::as_is, "it has just been removed"},
        Refusal{EINVAL, {}, GpioUse::input, GpioBias::as_is, kKernelLacksIt},
        Refusal{EPERM,
                {},
                GpioUse::input,
                GpioBias::pull_up,
                "this program may not open any GPIO chip, not even as root; does its service's "
                "unit lack `DeviceAllow=char-gpiochip rw`?"},
        Refusal{EINVAL, {"", true, ""}, GpioUse::input, GpioBias::pull_up, kInUseByNobodyKnown},
        Refusal{EOPNOTSUPP,
                {},
                GpioUse::output,
                GpioBias::as_is,
                "its chip cannot make an output of this line, or does not answer; use another"},
        Refusal{524,
                {},
                GpioUse::output,
                GpioBias::as_is,
                "its chip cannot make an output of this line, or does not answer; use another"},
        Refusal{EIO,
                {},
                GpioUse::input,
                GpioBias::as_is,
                "its chip cannot make an input of this line, or does not answer; use another"},
        Refusal{ENOMEM,
                {},
                GpioUse::output,
                GpioBias::as_is,
                "the kernel refuses it: Cannot allocate memory"}));

}  // namespace
}  // namespace tribus::gpio_search_test
