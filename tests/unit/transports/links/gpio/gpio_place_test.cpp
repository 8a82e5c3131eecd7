#include "transports/links/gpio/gpio_place.h"

#include <string>
#include <string_view>
#include <variant>

#include <gtest/gtest.h>

namespace tribus::gpio_place_test {
namespace {

std::string error_of(std::string_view text) {
    const auto place = parse_gpio_place(text);
    return place ? "" : place.error();
}

TEST(GpioPlaceTest, IsANameOnAnyChip) {
    const auto place = parse_gpio_place("GPIO17");
    ASSERT_TRUE(place) << place.error();
    EXPECT_EQ(place->chip, "");
    EXPECT_EQ(std::get<std::string>(place->line), "GPIO17");
}

TEST(GpioPlaceTest, IsAnOffsetOnAChip) {
    const auto place = parse_gpio_place("gpiochip0:17");
    ASSERT_TRUE(place) << place.error();
    EXPECT_EQ(place->chip, "gpiochip0");
    EXPECT_EQ(std::get<unsigned>(place->line), 17U);
}

TEST(GpioPlaceTest, IsANameOnAChip) {
    const auto place = parse_gpio_place("gpiochip4:GPIO17");
    ASSERT_TRUE(place) << place.error();
    EXPECT_EQ(place->chip, "gpiochip4");
    EXPECT_EQ(std::get<std::string>(place->line), "GPIO17");
}

TEST(GpioPlaceTest, TakesAPathOfAChip) {
    const auto place = parse_gpio_place("/dev/gpiochip0:17");
    ASSERT_TRUE(place) << place.error();
    EXPECT_EQ(place->chip, "/dev/gpiochip0");
    EXPECT_EQ(std::get<unsigned>(place->line), 17U);
}

TEST(GpioPlaceTest, TakesAPathWithColons) {
    const auto place = parse_gpio_place("/dev/gpio/pci-0000:00:1f.0:3");
    ASSERT_TRUE(place) << place.error();
    EXPECT_EQ(place->chip, "/dev/gpio/pci-0000:00:1f.0");
    EXPECT_EQ(std::get<unsigned>(place->line), 3U);
}

// Line names of real boards: Raspberry Pi, Odroid, Rock Pi, STM32MP1, UP.
TEST(GpioPlaceTest, TakesTheNamesThatBoardsGive) {
    for (const std::string name :
         {"ID_SDA", "PIN_7", "7J1 Header Pin5", "[GPIO4_C5]", "PG3", "SPI0 CS:1", "5"}) {
        const auto place = parse_gpio_place("gpiochip1:" + name);
        ASSERT_TRUE(place) << place.error();
        if (name != "5") {
            EXPECT_EQ(std::get<std::string>(place->line), name);
            EXPECT_TRUE(std::holds_alternative<std::string>(parse_gpio_place(name)->line));
        }
    }
}

TEST(GpioPlaceTest, IsAnOffsetOfAnyDigits) {
    EXPECT_EQ(parse_gpio_place("gpiochip0:0"), (GpioPlace{"gpiochip0", 0U}));
    EXPECT_EQ(parse_gpio_place("gpiochip0:109"), (GpioPlace{"gpiochip0", 109U}));
    EXPECT_EQ(parse_gpio_place("gpiochip0:1/"), (GpioPlace{"gpiochip0", "1/"}));
    EXPECT_EQ(parse_gpio_place("gpiochip0:1:"), (GpioPlace{"gpiochip0", "1:"}));
}

TEST(GpioPlaceTest, EndsWithItsText) {
    EXPECT_EQ(parse_gpio_place(std::string_view("gpiochip0:1799").substr(0, 12)),
              (GpioPlace{"gpiochip0", 17U}));
}

TEST(GpioPlaceTest, ReadsBackWhatItPrints) {
    for (const std::string_view text :
         {"GPIO17", "gpiochip0:17", "gpiochip0:GPIO17", "/dev/gpiochip0:0"}) {
        EXPECT_EQ(to_text(*parse_gpio_place(text)), text);
    }
}

TEST(GpioPlaceTest, KnowsThePathOfAChip) {
    EXPECT_EQ(chip_path({"gpiochip0", 1U}), "/dev/gpiochip0");
    EXPECT_EQ(chip_path({"/dev/gpio/header", 1U}), "/dev/gpio/header");
}

TEST(GpioPlaceTest, RefusesAChipWithoutALine) {
    EXPECT_EQ(error_of("gpiochip0"),
              "\"gpiochip0\" names a chip but no line: give a line's name, such as "
              "\"GPIO17\", or chip and offset, such as \"gpiochip0:17\"");
    EXPECT_TRUE(
        error_of("/dev/gpiochip0").starts_with("\"/dev/gpiochip0\" names a chip but no line"));
    EXPECT_TRUE(error_of("gpiochip0:").starts_with("\"gpiochip0:\" names no line"));
}

TEST(GpioPlaceTest, RefusesAnOffsetWithoutAChip) {
    EXPECT_TRUE(error_of("17").starts_with("\"17\" is an offset without its chip"));
}

TEST(GpioPlaceTest, RefusesNothing) {
    EXPECT_TRUE(error_of("").starts_with("\"\" names no line"));
}

TEST(GpioPlaceTest, RefusesAnOffsetBeyondAllNumbers) {
    EXPECT_TRUE(error_of("gpiochip0:4294967295").empty());
    EXPECT_TRUE(error_of("gpiochip0:4294967296")
                    .starts_with("\"gpiochip0:4294967296\" has an offset that is too large"));
}

}  // namespace
}  // namespace tribus::gpio_place_test
