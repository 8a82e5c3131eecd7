#include "transports/links/evdev/evdev_link.h"

#include <linux/input.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <deque>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "pipelines/realtime/clock.h"
#include "tests/support/device_stand_in.h"
#include "tests/support/fewer_descriptors.h"
#include "tests/support/seen_within.h"
#include "transports/links/evdev/evdev_medium.h"

/// The link of a gamepad with a stand-in for the kernel's evdev.
namespace tribus::test::evdev_link_test {
namespace {

using namespace std::chrono_literals;
using Report = std::vector<int>;

constexpr const char* kDevice = "/dev/input/event-of-a-test";

input_event event(int type, int code, int value) {
    input_event event{};
    event.type = static_cast<std::uint16_t>(type);
    event.code = static_cast<std::uint16_t>(code);
    event.value = value;
    return event;
}

input_event report_end() {
    return event(EV_SYN, SYN_REPORT, 0);
}

/// The device node of a gamepad as evdev has it (linux/input.h, drivers/input/evdev.c): EVIOCGABS
/// and EVIOCGRAB return 0, sets of codes their length. A read returns whole events or EAGAIN, and
/// ENODEV once the device is gone.
class Pad : public DeviceStandIn {
  public:
    Pad() : DeviceStandIn(kDevice) {}

    Answer open() override { return opening; }

    Answer control(unsigned long request, void* argument) override {
        if (request == EVIOCGID) {
            return 0;
        }
        if (request == EVIOCGRAB) {
            grabbed = argument == reinterpret_cast<void*>(1);
            return 0;
        }
        if (request == EVIOCGBIT(EV_ABS, ABS_CNT / 8)) {
            return set_of(axes, argument, ABS_CNT / 8);
        }
        if (request == EVIOCGKEY(KEY_CNT / 8)) {
            return set_of(pressed, argument, KEY_CNT / 8);
        }
        const auto code = static_cast<int>(request - EVIOCGABS(0));
        if (code >= 0 && code < ABS_CNT) {
            *static_cast<input_absinfo*>(argument) = ranges[code];
            return 0;
        }
        return -EINVAL;
    }

    Answer read(std::span<std::uint8_t> room) override {
        ++reads;
        if (failure != 0) {
            return -failure;
        }
        const std::size_t count = std::min(waiting.size(), room.size() / sizeof(input_event));
        for (std::size_t i = 0; i < count; ++i) {
            std::memcpy(&room[i * sizeof(input_event)], &waiting[i], sizeof(input_event));
        }
        waiting.erase(waiting.begin(), waiting.begin() + static_cast<std::ptrdiff_t>(count));
        return count == 0 ? -EAGAIN : static_cast<long>(count * sizeof(input_event));
    }

    void add_axis(int code, int least, int most, int value) {
        axes.insert(code);
        ranges[code] = {.value = value,
                        .minimum = least,
                        .maximum = most,
                        .fuzz = 0,
                        .flat = 0,
                        .resolution = 0};
    }
    void happens(const std::vector<input_event>& events) {
        waiting.insert(waiting.end(), events.begin(), events.end());
    }

    Answer opening{};
    std::set<int> axes{};
    std::map<int, input_absinfo> ranges{};
    std::set<int> pressed{};
    std::deque<input_event> waiting{};
    int failure = 0;
    int reads = 0;
    bool grabbed = false;

  private:
    static long set_of(const std::set<int>& codes, void* argument, std::size_t size) {
        auto* const bytes = static_cast<std::uint8_t*>(argument);
        std::memset(bytes, 0, size);
        for (const int code : codes) {
            bytes[code / 8] |= static_cast<std::uint8_t>(1 << code % 8);
        }
        return static_cast<long>(size);
    }
};

std::unique_ptr<EvdevLink> opened(bool grab = true) {
    auto link = EvdevLink::open(kDevice, grab);
    EXPECT_TRUE(link.has_value()) << (link ? "" : link.error());
    return link ? std::move(*link) : nullptr;
}

std::string refusal(bool grab = true) {
    const auto link = EvdevLink::open(kDevice, grab);
    return link ? "it opened" : link.error();
}

/// The next report; empty if there is none. The timer of the link makes one each 20 ms.
Report report_of(EvdevLink& link) {
    Reception reception;
    link.read(reception);
    return {reception.view().begin(), reception.view().end()};
}

/// A report at once.
Report first_report(Pad& pad, EvdevLink& link) {
    pad.happens({report_end()});
    return report_of(link);
}

/// Reads what waits and one tick, if there is one, so that nothing is left.
void settle(EvdevLink& link) {
    Reception reception;
    ASSERT_TRUE(seen_within([&] { return link.read(reception) == ReadStatus::nothing; }, 5s));
}

TEST(EvdevLink, BeginsWithTheWholeState) {
    Pad pad;
    pad.add_axis(ABS_X, -100, 100, -100);
    pad.add_axis(ABS_RZ, 0, 10, 10);
    pad.pressed = {BTN_MISC, BTN_SOUTH, KEY_A, KEY_CNT - 1};
    const auto link = opened();
    EXPECT_EQ(first_report(pad, *link), (Report{0x67, 2, 2, 3,       //
                                                ABS_X, 0x01, 0x80,   //
                                                ABS_RZ, 0xFF, 0x7F,  //
                                                0x00, 0x01, 0x30, 0x01, 0xFF, 0x02}))
        << "keys of a keyboard are none";
}

// The axes behind ABS_MT_SLOT are those of fingers.
TEST(EvdevLink, HasTheAxesThatTheDeviceHasUpToThoseOfFingers) {
    Pad pad;
    pad.add_axis(ABS_HAT0X, -1, 1, 1);
    pad.add_axis(ABS_MT_SLOT - 1, -1, 1, 1);
    pad.add_axis(ABS_MT_SLOT, -1, 1, 1);
    pad.ranges[ABS_Y] = {
        .value = 1, .minimum = -1, .maximum = 1, .fuzz = 0, .flat = 0, .resolution = 0};
    const auto link = opened();
    EXPECT_EQ(first_report(pad, *link), (Report{0x67, 2, 2, 0,          //
                                                ABS_HAT0X, 0xFF, 0x7F,  //
                                                ABS_MT_SLOT - 1, 0xFF, 0x7F}));
}

TEST(EvdevLink, LeavesOutAnAxisWhoseRangeTheKernelDoesNotTell) {
    Pad pad;
    pad.add_axis(ABS_X, -1, 1, 0);
    pad.add_axis(ABS_Y, -1, 1, 0);
    pad.refused[EVIOCGABS(ABS_X)] = EINVAL;
    const auto link = opened();
    EXPECT_EQ(first_report(pad, *link), (Report{0x67, 2, 1, 0, ABS_Y, 0, 0}));
}

TEST(EvdevLink, TakesTheDeviceForItselfOnlyIfAsked) {
    for (const bool grab : {false, true}) {
        Pad pad;
        const auto link = opened(grab);
        EXPECT_EQ(pad.grabbed, grab);
    }
    Pad pad;
    ASSERT_TRUE(kEvdevMedium.open(kDevice, {}).has_value());
    EXPECT_TRUE(pad.grabbed) << "unless the configuration says otherwise";
}

TEST(EvdevLink, SaysWhatIsInItsWay) {
    Pad pad;
    pad.opening = -EACCES;
    EXPECT_TRUE(refusal().starts_with(std::string(kDevice) + ": this user may not read it"));
    pad.opening = -ENOENT;
    EXPECT_EQ(refusal(), std::string(kDevice) + ": there is no such device");
    pad.opening = {};
    pad.refused = {{EVIOCGID, EINVAL}};
    EXPECT_TRUE(refusal().starts_with(std::string(kDevice) + ": this is no input device"));
    pad.refused = {{EVIOCGRAB, EBUSY}};
    EXPECT_EQ(refusal(), std::string(kDevice) +
                             ": another program has taken it for itself; stop "
                             "it, or set grab = false");
    EXPECT_EQ(refusal(false), "it opened");
}

TEST(EvdevLink, SaysThatThereIsNoDescriptorLeftForItsTimer) {
    const Pad pad;
    const FewerDescriptors fewer(1);
    EXPECT_EQ(refusal(), std::string(kDevice) + ": Too many open files");
}

TEST(EvdevLink, GivesAReportAfterEachChange) {
    Pad pad;
    pad.add_axis(ABS_X, -100, 100, 0);
    const auto link = opened();
    settle(*link);
    pad.happens({event(EV_ABS, ABS_X, 100), event(EV_KEY, BTN_EAST, 1), report_end()});
    Reception reception;
    reception.goes_on = true;
    reception.full = true;
    reception.damaged.set();
    EXPECT_EQ(link->read(reception), ReadStatus::received);
    EXPECT_EQ(Report(reception.view().begin(), reception.view().end()),
              (Report{0x67, 2, 1, 1, ABS_X, 0xFF, 0x7F, 0x31, 0x01}));
    EXPECT_FALSE(reception.full);
    EXPECT_FALSE(reception.goes_on);
    EXPECT_TRUE(reception.damaged.none());
}

TEST(EvdevLink, HasNothingBetweenChangesAndTicks) {
    Pad pad;
    const auto link = opened();
    Reception reception;
    EXPECT_TRUE(seen_within(
        [&] {
            reception.count = 9;
            reception.full = true;
            reception.goes_on = true;
            reception.damaged.set();
            return link->read(reception) == ReadStatus::nothing;
        },
        5s));
    EXPECT_EQ(reception.count, 0U);
    EXPECT_FALSE(reception.full || reception.goes_on || reception.damaged.any());
}

TEST(EvdevLink, AnInterruptedReadIsNothing) {
    Pad pad;
    pad.failure = EINTR;
    const auto link = opened();
    settle(*link);
    pad.failure = 0;
    pad.happens({event(EV_KEY, BTN_EAST, 1), report_end()});
    EXPECT_EQ(report_of(*link), (Report{0x67, 2, 0, 1, 0x31, 0x01})) << "the device is still there";
}

TEST(EvdevLink, RepeatsItsReportEach20Milliseconds) {
    const Instant begin = monotonic_now();
    Pad pad;
    pad.add_axis(ABS_X, -100, 100, 100);
    const auto link = opened();
    itimerspec set{};
    ASSERT_EQ(::timerfd_gettime(link->second_descriptor(), &set), 0);
    EXPECT_EQ(set.it_interval.tv_sec, 0);
    EXPECT_EQ(set.it_interval.tv_nsec, 20'000'000);
    pollfd timer{.fd = link->second_descriptor(), .events = POLLIN, .revents = 0};
    ASSERT_EQ(::poll(&timer, 1, -1), 1);
    std::uint64_t ticks = 0;
    ASSERT_EQ(::read(link->second_descriptor(), &ticks, sizeof ticks), 8);
    EXPECT_LE(static_cast<std::int64_t>(ticks), (monotonic_now() - begin) / 20ms);
    first_report(pad, *link);
    ASSERT_EQ(::poll(&timer, 1, -1), 1);
    EXPECT_EQ(report_of(*link), (Report{0x67, 0, 1, 0, ABS_X, 0xFF, 0x7F}));
}

TEST(EvdevLink, ReadsTheWholeStateAnewWhereTheKernelDroppedEvents) {
    Pad pad;
    pad.add_axis(ABS_X, -100, 100, 0);
    pad.add_axis(ABS_Y, -100, 100, 100);
    pad.pressed = {BTN_SOUTH};
    const auto link = opened();
    first_report(pad, *link);
    pad.ranges[ABS_X].value = 100;
    pad.ranges[ABS_Y].value = -100;
    pad.pressed = {BTN_EAST};
    pad.happens({event(EV_SYN, SYN_DROPPED, 0), report_end()});
    EXPECT_EQ(report_of(*link), (Report{0x67, 2, 2, 1,      //
                                        ABS_X, 0xFF, 0x7F,  //
                                        ABS_Y, 0x01, 0x80,  //
                                        0x31, 0x01}));
}

TEST(EvdevLink, KeepsTheStateThatTheKernelDoesNotTellAnew) {
    Pad pad;
    pad.add_axis(ABS_X, -100, 100, 100);
    pad.pressed = {BTN_SOUTH};
    const auto link = opened();
    pad.refused = {{EVIOCGABS(ABS_X), ENODEV}, {EVIOCGKEY(KEY_CNT / 8), ENODEV}};
    pad.happens({event(EV_SYN, SYN_DROPPED, 0), report_end()});
    report_of(*link);
    pad.happens({event(EV_SYN, SYN_DROPPED, 0), report_end()});
    EXPECT_EQ(report_of(*link), (Report{0x67, 0, 1, 1, ABS_X, 0xFF, 0x7F, 0x30, 0x01}));
}

TEST(EvdevLink, ReadsAtMost1024EventsAtATime) {
    Pad pad;
    pad.add_axis(ABS_X, 0, 10'000, 0);
    const auto link = opened();
    for (int i = 0; i < 2000; ++i) {
        pad.happens({event(EV_ABS, ABS_X, i)});
    }
    report_of(*link);
    EXPECT_EQ(pad.waiting.size(), 2000U - 1024);
    EXPECT_EQ(pad.reads, 16);
}

TEST(EvdevLink, ReadsNoFurtherThanAReadThatWasNotFull) {
    Pad pad;
    const auto link = opened();
    pad.happens({event(EV_KEY, BTN_EAST, 1), report_end()});
    report_of(*link);
    EXPECT_EQ(pad.reads, 1);
}

TEST(EvdevLink, SaysInALastReportThatTheDeviceIsGone) {
    Pad pad;
    pad.add_axis(ABS_X, -100, 100, 100);
    const auto link = opened();
    first_report(pad, *link);
    pad.failure = ENODEV;
    Reception reception;
    EXPECT_EQ(link->read(reception), ReadStatus::received);
    EXPECT_EQ(Report(reception.view().begin(), reception.view().end()),
              (Report{0x67, 1, 1, 0, ABS_X, 0xFF, 0x7F}));
    EXPECT_TRUE(reception.full) << "the loss is to be seen at once";
    pad.failure = 0;
    EXPECT_EQ(link->read(reception), ReadStatus::lost);
    EXPECT_EQ(reception.count, 0U);
    EXPECT_FALSE(reception.full);
}

TEST(EvdevLink, DiscardsEventsAndKeepsWhatTheySaid) {
    Pad pad;
    pad.add_axis(ABS_X, -100, 100, 0);
    const auto link = opened();
    pad.happens({event(EV_ABS, ABS_X, 100), report_end()});
    link->discard_unread();
    EXPECT_TRUE(pad.waiting.empty());
    EXPECT_EQ(first_report(pad, *link), (Report{0x67, 2, 1, 0, ABS_X, 0xFF, 0x7F}));
}

TEST(EvdevLink, CanOnlyRead) {
    const Pad pad;
    const auto link = opened();
    EXPECT_EQ(link->write({}), WriteStatus::unavailable);
    EXPECT_GE(link->descriptor(), 0);
}

}  // namespace
}  // namespace tribus::test::evdev_link_test
