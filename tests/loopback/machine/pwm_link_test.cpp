#include "transports/links/pwm/pwm_link.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include <gtest/gtest.h>

#include "pipelines/realtime/clock.h"
#include "tests/support/nothing_to_read.h"
#include "tests/support/pwm_folder.h"
#include "tests/support/seen_within.h"
#include "transports/links/unique_fd.h"

/// The link's own thread over a folder with the files of /sys/class/pwm.
namespace tribus::test::pwm_link_test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

/// Waits until the link's own thread has written that, and takes it.
bool comes(const PwmFolder& folder, std::size_t output, const std::string& file,
           const std::string& wanted) {
    return seen_within([&] { return folder.text("pwmchip0", output, file) == wanted; }) &&
           folder.take("pwmchip0", output, file) == wanted;
}

/// Output 0: 1,500,000 ns.
constexpr std::array<std::uint8_t, 5> kCentre{0, 0x60, 0xE3, 0x16, 0x00};

/// Waits until the link says that of a frame.
bool says(PwmLink& link, WriteStatus status) {
    return seen_within([&] { return link.write(kCentre) == status; });
}

TEST(PwmLink, HasNothingToRead) {
    PwmFolder folder;
    folder.add("pwmchip0", "x", 1);
    auto link = PwmLink::open("pwmchip0", 20ms, {.now = monotonic_now}, folder.root());
    ASSERT_TRUE(link) << link.error();
    expect_nothing_to_read(**link);
}

TEST(PwmLink, RefusesAnOutputThatItsChipDoesNotHaveAndNoOtherForThat) {
    PwmFolder folder;
    folder.add("pwmchip0", "x", 2);
    auto link = PwmLink::open("pwmchip0", 20ms, {.now = monotonic_now}, folder.root());
    ASSERT_TRUE(link) << link.error();
    const std::array<std::uint8_t, 5> beyond{2, 0x60, 0xE3, 0x16, 0x00};
    EXPECT_EQ((*link)->write(beyond), WriteStatus::unavailable);
    EXPECT_TRUE(seen_within([&] {
        (*link)->write(kCentre);
        return folder.text("pwmchip0", 0, "enable") == "1";
    }));
    EXPECT_TRUE(says(**link, WriteStatus::written));
}

TEST(PwmLink, TakesNoRecordThatIsCut) {
    PwmFolder folder;
    folder.add("pwmchip0", "x", 2);
    auto link = PwmLink::open("pwmchip0", 20ms, {.now = monotonic_now}, folder.root());
    ASSERT_TRUE(link) << link.error();
    const std::array<std::uint8_t, 9> frame{0, 0x60, 0xE3, 0x16, 0x00, 1, 0x60, 0xE3, 0x16};
    EXPECT_TRUE(seen_within([&] {
        (*link)->write(frame);
        return folder.text("pwmchip0", 0, "enable") == "1";
    }));
    link->reset();
    EXPECT_EQ(folder.take("pwmchip0", 1, "duty_cycle"), "");
}

TEST(PwmLink, SaysWhatIsWrongWithItsChip) {
    PwmFolder folder;
    folder.add("pwmchip0", "x", 2);
    const auto error_of = [&](const std::string& chip) {
        const auto link = PwmLink::open(chip, 20ms, {.now = monotonic_now}, folder.root());
        return link ? "" : link.error();
    };
    EXPECT_EQ(error_of("pwmchip7"),
              "pwmchip7: there is no such PWM chip; this machine has pwmchip0 (x)");
    fs::remove(folder.chips() / "pwmchip0/export");
    EXPECT_EQ(error_of("pwmchip0"),
              "pwmchip0: this user may not use it; the package's udev rule gives it to the group "
              "gpio: join the group, and for a service see "
              "/usr/share/doc/tribus/docs/service.md, \"PWM in the service\"");
}

TEST(PwmLink, HandsTheNewestPulsesOnAndSwitchesOffAtItsEnd) {
    PwmFolder folder;
    folder.add("pwmchip0", "x", 4);
    auto link = PwmLink::open("pwmchip0", 10ms, {.now = monotonic_now}, folder.root());
    ASSERT_TRUE(link) << link.error();
    // Output 1: 1,500,000 ns; output 3: 1,000,000 ns.
    const std::array<std::uint8_t, 10> frame{1, 0x60, 0xE3, 0x16, 0x00, 3, 0x40, 0x42, 0x0F, 0x00};
    // A busy machine may be late with the link's thread: pulses are handed on for 200 ms only.
    EXPECT_TRUE(seen_within([&] {
        (*link)->write(frame);
        return folder.text("pwmchip0", 3, "enable") == "1";
    }));
    EXPECT_EQ(folder.take("pwmchip0", 1, "duty_cycle"), "1500000");
    EXPECT_EQ(folder.take("pwmchip0", 3, "duty_cycle"), "1000000");
    const std::array<std::uint8_t, 5> beyond{4, 0x60, 0xE3, 0x16, 0x00};
    EXPECT_EQ((*link)->write(beyond), WriteStatus::unavailable);
    link->reset();
    EXPECT_EQ(folder.take("pwmchip0", 1, "enable"), "0");
    EXPECT_EQ(folder.take("pwmchip0", 3, "enable"), "0");
    EXPECT_EQ(folder.take("pwmchip0", 0, "enable"), "");
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
    EXPECT_TRUE(seen_within([&] {
        told = write(high, 5s);
        return told != WriteStatus::written;
    }));
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

}  // namespace
}  // namespace tribus::test::pwm_link_test
