#include "transports/links/gpio/gpio_line.h"

#include <fcntl.h>
#include <poll.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "core/time.h"
#include "tests/support/fewer_descriptors.h"
#include "tests/support/gpiod_stand_in.h"
#include "tests/support/own_dev.h"
#include "transports/links/gpio/gpio_library.h"

/// Lines of chips in a /dev of this program's own.
namespace tribus::test::gpio_line_test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

std::string error_of(const GpioPlace& place) {
    const auto output = GpioOutput::open(place, false, true);
    return output ? "" : output.error();
}

/// Their paths, each with its error or the number of its lines.
std::string chips_found() {
    const auto chips = find_gpio_chips();
    if (!chips) {
        return "errno " + std::to_string(chips.error());
    }
    std::string text;
    for (const GpioChip& chip : *chips) {
        text += (text.empty() ? "" : ", ") + chip.path + " " +
                (chip.error != 0 ? "errno " + std::to_string(chip.error)
                                 : std::to_string(chip.lines.size()));
    }
    return text;
}

TEST(GpioChips, ComeInTheOrderOfTheirNumbers) {
    EXPECT_EQ(chips_found(), "");
    const GpioChipStandIn nine("gpiochip9", {{}});
    const GpioChipStandIn two("gpiochip2", {{}, {}});
    const GpioChipStandIn ten("gpiochip10", {{}});
    const GpioChipStandIn one("gpiochip1", {});
    EXPECT_EQ(chips_found(),
              "/dev/gpiochip1 0, /dev/gpiochip2 2, /dev/gpiochip9 1, /dev/gpiochip10 1");
}

TEST(GpioChips, AreDevicesWithThisNameAndNothingElse) {
    const GpioChipStandIn chip("gpiochip0", {{}});
    const DeviceFile other("null");
    std::ofstream("/dev/gpiochip5") << "a file";
    fs::create_symlink("gpiochip0", "/dev/gpiochip6");
    fs::create_directory("/dev/gpiochip7");
    EXPECT_EQ(chips_found(), "/dev/gpiochip0 1");
    for (const char* name : {"/dev/gpiochip5", "/dev/gpiochip6", "/dev/gpiochip7"}) {
        fs::remove(name);
    }
}

TEST(GpioChips, WhoseLinesAreUnknownSayWhy) {
    GpioChipStandIn closed("gpiochip0", {{}});
    closed.refuse(EACCES);
    const GpioChipStandIn open("gpiochip1", {{.name = "LAMP"}});
    EXPECT_EQ(chips_found(), "/dev/gpiochip0 errno 13, /dev/gpiochip1 1");
    EXPECT_EQ(find_gpio_chips()->back().lines.front().name, "LAMP");
}

TEST(GpioChips, AreUnknownWhereTheFolderOfDevicesCannotBeRead) {
    const GpioChipStandIn chip("gpiochip0", {{}});
    std::string found;
    std::string opened;
    bool absent = true;
    {
        const FewerDescriptors none(0);
        found = chips_found();
        opened = error_of({"gpiochip0", 0U});
        absent = is_gpio_line_absent({"gpiochip9", 0U});
    }
    EXPECT_EQ(found, "errno 24");
    EXPECT_EQ(opened, "gpiochip0:0: /dev: Too many open files");
    EXPECT_FALSE(absent) << "nobody knows";
}

TEST(GpioChipPath, IsThatToWhichLinksLead) {
    const GpioChipStandIn chip("gpiochip0", {{}});
    fs::create_symlink("gpiochip0", "/dev/header");
    EXPECT_EQ(followed_chip_path({"/dev/header", 1U}), "/dev/gpiochip0");
    EXPECT_EQ(followed_chip_path({"gpiochip0", 1U}), "/dev/gpiochip0");
    fs::remove("/dev/header");
    EXPECT_EQ(followed_chip_path({"gpiochip7", 1U}), "/dev/gpiochip7") << "there is none";
    EXPECT_EQ(followed_chip_path({"", "LAMP"}), "") << "any chip";
}

TEST(GpioLineIsAbsent, IfItsChipIsNotThere) {
    const GpioChipStandIn chip("gpiochip0", {{}});
    EXPECT_TRUE(is_gpio_line_absent({"gpiochip1", 0U}));
    EXPECT_TRUE(is_gpio_line_absent({"gpiochip1", "LAMP"}));
    EXPECT_FALSE(is_gpio_line_absent({"gpiochip0", 0U}));
    EXPECT_FALSE(is_gpio_line_absent({"gpiochip0", "LAMP"})) << "a mistake, not an absence";
    EXPECT_FALSE(is_gpio_line_absent({"gpiochip0", 5U})) << "likewise";
}

TEST(GpioLineIsAbsent, IfNoChipHasALineWithThatName) {
    EXPECT_TRUE(is_gpio_line_absent({"", "LAMP"})) << "no chip at all";
    const GpioChipStandIn chip("gpiochip0", {{}, {.name = "LAMP"}});
    EXPECT_FALSE(is_gpio_line_absent({"", "LAMP"}));
    EXPECT_TRUE(is_gpio_line_absent({"", "VALVE"}));
    GpioChipStandIn closed("gpiochip1", {{}});
    closed.refuse(EACCES);
    EXPECT_FALSE(is_gpio_line_absent({"", "VALVE"})) << "the closed one may have it";
}

TEST(GpioOutput, IsTheLineThatIsMeant) {
    const GpioChipStandIn first("gpiochip0", {{}, {.name = "VALVE"}});
    const GpioChipStandIn second("gpiochip1", {{}, {}, {.name = "LAMP"}});
    const auto by_name = GpioOutput::open({"", "LAMP"}, false, true);
    ASSERT_TRUE(by_name) << by_name.error();
    EXPECT_EQ(second.requested(2), "tribus: output");
    EXPECT_TRUE(second.is_high(2));
    const auto by_number = GpioOutput::open({"/dev/gpiochip0", 1U}, false, true);
    ASSERT_TRUE(by_number) << by_number.error();
    EXPECT_EQ(first.requested(1), "tribus: output");
    EXPECT_EQ(first.requested(0), "");
}

struct Start {
    bool active_low;
    bool active;
    bool high;
};

class GpioOutputStart : public testing::TestWithParam<Start> {};

TEST_P(GpioOutputStart, IsAtItsLevel) {
    const auto [active_low, active, high] = GetParam();
    const GpioChipStandIn chip("gpiochip0", {{.high = !high}});
    const auto output = GpioOutput::open({"gpiochip0", 0U}, active_low, active);
    ASSERT_TRUE(output) << output.error();
    EXPECT_EQ(chip.is_high(0), high);
    EXPECT_TRUE((*output)->set(!active));
    EXPECT_EQ(chip.is_high(0), !high);
}

INSTANTIATE_TEST_SUITE_P(Levels, GpioOutputStart,
                         testing::Values(Start{false, false, false}, Start{false, true, true},
                                         Start{true, false, true}, Start{true, true, false}));

TEST(GpioOutput, SaysThatItsChipIsGone) {
    GpioChipStandIn chip("gpiochip0", {{}});
    const auto output = GpioOutput::open({"gpiochip0", 0U}, false, false);
    ASSERT_TRUE(output) << output.error();
    chip.unplug();
    EXPECT_FALSE((*output)->set(true));
    EXPECT_EQ(error_of({"gpiochip0", 0U}).rfind("gpiochip0:0: this machine has no GPIO chips", 0),
              0U);
}

TEST(GpioErrors, BeginWithThePlace) {
    EXPECT_EQ(error_of({"", "LAMP"}).rfind("LAMP: this machine has no GPIO chips", 0), 0U);
    const GpioChipStandIn chip("gpiochip0", {{}, {.refusal = EIO}});
    EXPECT_EQ(error_of({"gpiochip0", 2U}),
              "gpiochip0:2: this chip has 2 lines: give an offset from 0 to 1");
    EXPECT_EQ(error_of({"gpiochip3", 2U}),
              "gpiochip3:2: there is no such GPIO chip; this machine has gpiochip0; `gpiodetect` "
              "(package gpiod) describes them");
    EXPECT_EQ(error_of({"gpiochip0", 1U}),
              "gpiochip0:1: its chip cannot make an output of this line, or does not answer; use "
              "another");
}

TEST(GpioErrors, SayWhoHasTheLine) {
    const GpioChipStandIn chip("gpiochip0", {{}, {}, {.consumer = "lab-hog"}, {.used = true}});
    const auto holder = GpioInput::open({"gpiochip0", 1U}, false, GpioBias::as_is);
    ASSERT_TRUE(holder) << holder.error();
    EXPECT_EQ(error_of({"gpiochip0", 1U}),
              "gpiochip0:1: it is in use by \"tribus\", a program, a driver or the device tree: "
              "end that, or use another line");
    EXPECT_EQ(error_of({"gpiochip0", 2U}),
              "gpiochip0:2: it is in use by \"lab-hog\", a program, a driver or the device tree: "
              "end that, or use another line");
    EXPECT_EQ(
        error_of({"gpiochip0", 3U}).rfind("gpiochip0:3: it is in use, the kernel does not", 0), 0U);
}

TEST(GpioErrors, AreThoseOfAnInputForAnInput) {
    const GpioChipStandIn chip("gpiochip0", {{.refusal = ENXIO}, {.refusal = EINVAL}});
    const auto no_interrupt = GpioInput::open({"gpiochip0", 0U}, false, GpioBias::as_is);
    ASSERT_FALSE(no_interrupt);
    EXPECT_EQ(no_interrupt.error(),
              "gpiochip0:0: its chip does not report changes of this line (it has no interrupt), "
              "or is gone; use a line of another chip");
    const auto no_resistor = GpioInput::open({"gpiochip0", 1U}, false, GpioBias::pull_up);
    ASSERT_FALSE(no_resistor);
    EXPECT_EQ(no_resistor.error().rfind("gpiochip0:1: the kernel refuses a bias for it", 0), 0U);
    const auto edges = hold_for_edges({"gpiochip0", 1U}, GpioEdges::rising, GpioBias::pull_up);
    ASSERT_FALSE(edges);
    EXPECT_EQ(edges.error(), no_resistor.error());
}

TEST(GpioInput, IsRequestedAsItIsConfigured) {
    const GpioChipStandIn chip("gpiochip0", {{}, {}, {}});
    const auto low = GpioInput::open({"gpiochip0", 1U}, true, GpioBias::pull_up);
    ASSERT_TRUE(low) << low.error();
    EXPECT_EQ(chip.requested(1), "tribus: both edges, active-low, pull-up");
    EXPECT_EQ((*low)->read(), std::optional(true));
    const auto high = GpioInput::open({"gpiochip0", 2U}, false, GpioBias::pull_down);
    ASSERT_TRUE(high) << high.error();
    EXPECT_EQ(chip.requested(2), "tribus: both edges, pull-down");
    EXPECT_EQ((*high)->read(), std::optional(false));
}

TEST(GpioLineForEdges, IsRequestedAsItIsConfigured) {
    GpioChipStandIn chip("gpiochip0", {{}, {}});
    const auto line = hold_for_edges({"gpiochip0", 1U}, GpioEdges::falling, GpioBias::pull_up);
    ASSERT_TRUE(line) << line.error();
    EXPECT_EQ(chip.requested(1), "tribus: falling edges, pull-up");
    EXPECT_NE(::fcntl((*line)->descriptor(), F_GETFL) & O_NONBLOCK, 0);
    chip.drive(1, true, 1000);
    chip.drive(1, false, 2000);
    std::array<GpioEdge, kEdgesPerRead> edges{};
    EXPECT_EQ((*line)->read_edges(edges), 1U);
    EXPECT_EQ(edges[0].nanoseconds, 2000U);
}

class GpioInputRead : public testing::Test {
  protected:
    void SetUp() override {
        auto input = GpioInput::open({"gpiochip0", 0U}, false, GpioBias::as_is);
        ASSERT_TRUE(input) << input.error();
        input_ = std::move(*input);
    }
    bool is_readable() const {
        pollfd line{.fd = input_->descriptor(), .events = POLLIN, .revents = 0};
        return ::poll(&line, 1, 0) > 0;
    }

    GpioChipStandIn chip_{"gpiochip0", {{}}};
    std::unique_ptr<GpioInput> input_;
};

TEST_F(GpioInputRead, DoesNotWaitAndTellsTheLevel) {
    EXPECT_NE(::fcntl(input_->descriptor(), F_GETFL) & O_NONBLOCK, 0);
    EXPECT_EQ(input_->read(), std::optional(false));
    chip_.drive(0, true);
    EXPECT_TRUE(is_readable());
    EXPECT_EQ(input_->read(), std::optional(true));
    EXPECT_FALSE(is_readable());
}

TEST_F(GpioInputRead, TellsWhenTheLatestEdgeCame) {
    EXPECT_EQ(input_->latest_edge(), std::nullopt);
    chip_.drive(0, true, 1000);
    chip_.drive(0, false, 3000);
    chip_.drive(0, true, 2500);
    input_->read();
    EXPECT_EQ(input_->latest_edge(), std::optional<Duration>(2500ns));
    input_->read();
    EXPECT_EQ(input_->latest_edge(), std::nullopt) << "none came since";
    chip_.drive(0, false, 4000);
    input_->read();
    EXPECT_EQ(input_->latest_edge(), std::optional<Duration>(4000ns));
}

TEST_F(GpioInputRead, DoesNotKnowWhenTheLatestOfManyEdgesCame) {
    for (std::uint64_t edge = 1; edge <= 16; ++edge) {
        chip_.drive(0, edge % 2 != 0, edge);
    }
    EXPECT_EQ(input_->read(), std::optional(false));
    EXPECT_EQ(input_->latest_edge(), std::optional(Duration::max()));
    EXPECT_FALSE(is_readable());
    for (std::uint64_t edge = 1; edge <= 15; ++edge) {
        chip_.drive(0, edge % 2 != 0, edge);
    }
    EXPECT_EQ(input_->read(), std::optional(true));
    EXPECT_EQ(input_->latest_edge(), std::optional<Duration>(15ns));
}

TEST_F(GpioInputRead, TellsThatItsChipIsGone) {
    chip_.drive(0, true);
    input_->read();
    chip_.unplug();
    EXPECT_EQ(input_->read(), std::nullopt);
    EXPECT_EQ(input_->latest_edge(), std::nullopt);
}

TEST_F(GpioInputRead, TellsThatTheChipGivesNoLevel) {
    chip_.silence(0);
    EXPECT_EQ(input_->read(), std::nullopt);
}

}  // namespace
}  // namespace tribus::test::gpio_line_test
