#include <fcntl.h>
#include <linux/gpio.h>
#include <sys/ioctl.h>

#include <cerrno>
#include <cstdint>
#include <cstring>

#include <gtest/gtest.h>

#include "tests/lab/gpio_bank.h"
#include "transports/links/unique_fd.h"

/// Checks that the laboratory's simulated GPIO lines can be set and read.
namespace tribus::test::modules_gpio_test {
namespace {

/// Requests one line with the kernel's own interface, version 2.
UniqueFd request_line(const GpioBank& bank, unsigned line, std::uint64_t direction) {
    const UniqueFd chip(::open(bank.path().c_str(), O_RDWR | O_CLOEXEC));
    EXPECT_TRUE(chip.valid()) << bank.path() << ": " << std::strerror(errno);
    gpio_v2_line_request request{};
    request.offsets[0] = line;
    request.num_lines = 1;
    request.config.flags = direction;
    std::strncpy(request.consumer, "lab", sizeof(request.consumer) - 1);
    if (::ioctl(chip.get(), GPIO_V2_GET_LINE_IOCTL, &request) != 0) {
        return UniqueFd();
    }
    return UniqueFd(request.fd);
}

void set_level(const UniqueFd& line, bool level) {
    gpio_v2_line_values values{.bits = level ? 1U : 0U, .mask = 1};
    EXPECT_EQ(::ioctl(line.get(), GPIO_V2_LINE_SET_VALUES_IOCTL, &values), 0)
        << std::strerror(errno);
}

bool level_of(const UniqueFd& line) {
    gpio_v2_line_values values{.bits = 0, .mask = 1};
    EXPECT_EQ(::ioctl(line.get(), GPIO_V2_LINE_GET_VALUES_IOCTL, &values), 0)
        << std::strerror(errno);
    return (values.bits & 1U) != 0;
}

TEST(LabGpioBank, ShowsTheLevelThatARequestedLineIsSetTo) {
    const GpioBank bank;
    const UniqueFd line = request_line(bank, 5, GPIO_V2_LINE_FLAG_OUTPUT);
    ASSERT_TRUE(line.valid());
    set_level(line, true);
    EXPECT_EQ(bank.level(5), "1");
    EXPECT_EQ(bank.level(4), "0");
    set_level(line, false);
    EXPECT_EQ(bank.level(5), "0");
}

TEST(LabGpioBank, LetsALineBeRead) {
    const GpioBank bank;
    const UniqueFd line = request_line(bank, 2, GPIO_V2_LINE_FLAG_INPUT);
    ASSERT_TRUE(line.valid());
    bank.pull(2, true);
    EXPECT_TRUE(level_of(line));
    bank.pull(2, false);
    EXPECT_FALSE(level_of(line));
}

TEST(LabGpioBank, GivesALineToOneProgramOnly) {
    const GpioBank bank;
    const UniqueFd line = request_line(bank, 1, GPIO_V2_LINE_FLAG_OUTPUT);
    ASSERT_TRUE(line.valid());
    EXPECT_FALSE(request_line(bank, 1, GPIO_V2_LINE_FLAG_OUTPUT).valid());
    EXPECT_EQ(errno, EBUSY);
}

}  // namespace
}  // namespace tribus::test::modules_gpio_test
