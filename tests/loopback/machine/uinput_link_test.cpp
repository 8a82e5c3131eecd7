#include "transports/links/uinput/uinput_link.h"

#include <linux/uinput.h>
#include <sys/ioctl.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/device_stand_in.h"
#include "tests/support/nothing_to_read.h"

/// The link of a joystick that the kernel makes, with a stand-in for uinput.
namespace tribus::test::uinput_link_test {
namespace {

using Bytes = std::vector<std::uint8_t>;
/// Type, code and value.
using Event = std::array<int, 3>;
using Events = std::vector<Event>;

constexpr std::array kAxes{ABS_X, ABS_Y, ABS_Z, ABS_RX, ABS_RY, ABS_RZ, ABS_THROTTLE, ABS_RUDDER};

std::vector<int> buttons() {
    return {0x130, 0x131, 0x132, 0x133, 0x134, 0x135, 0x136, 0x137, 0x138, 0x139, 0x13A, 0x13B,
            0x13C, 0x13D, 0x13E, 0x13F, 0x2C0, 0x2C1, 0x2C2, 0x2C3, 0x2C4, 0x2C5, 0x2C6, 0x2C7};
}

/// /dev/uinput (linux/uinput.h, drivers/input/misc/uinput.c): each request returns 0, a write the
/// bytes of all events.
class Uinput : public DeviceStandIn {
  public:
    Uinput() : DeviceStandIn("/dev/uinput") {}

    Answer open() override { return opening; }

    Answer control(unsigned long request, void* argument) override {
        const auto number = static_cast<int>(reinterpret_cast<std::intptr_t>(argument));
        switch (request) {
            case UI_SET_EVBIT:
                types.push_back(number);
                return number == refused_number ? -EINVAL : 0;
            case UI_SET_KEYBIT:
                keys.push_back(number);
                return number == refused_number ? -EINVAL : 0;
            case UI_ABS_SETUP:
                axes.push_back(*static_cast<uinput_abs_setup*>(argument));
                return axes.back().code == refused_axis ? -EINVAL : 0;
            case UI_DEV_SETUP:
                setup = *static_cast<uinput_setup*>(argument);
                return 0;
            case UI_DEV_CREATE:
                created = true;
                return 0;
            default:
                return -EINVAL;
        }
    }

    Answer write(std::span<const std::uint8_t> bytes) override {
        ++writes;
        if (failure != 0) {
            return -failure;
        }
        for (std::size_t at = 0; at + sizeof(input_event) <= bytes.size();
             at += sizeof(input_event)) {
            input_event event{};
            std::memcpy(&event, &bytes[at], sizeof event);
            events.push_back({event.type, event.code, event.value});
        }
        return static_cast<long>(bytes.size());
    }

    Events taken() { return std::exchange(events, {}); }

    Answer opening{};
    std::vector<int> types{};
    std::vector<int> keys{};
    std::vector<uinput_abs_setup> axes{};
    uinput_setup setup{};
    bool created = false;
    int refused_number = -1;
    int refused_axis = -1;
    int writes = 0;
    int failure = 0;
    Events events{};
};

std::unique_ptr<UinputLink> opened(const std::string& name = "stick") {
    auto link = UinputLink::open(name);
    EXPECT_TRUE(link.has_value()) << (link ? "" : link.error());
    return link ? std::move(*link) : nullptr;
}

std::string refusal() {
    const auto link = UinputLink::open("stick");
    return link ? "it opened" : link.error();
}

const std::string kCannot = "stick: cannot make a joystick with /dev/uinput: ";

/// A report: three bytes of buttons, then the axes.
Bytes report(unsigned pressed, const std::array<int, 8>& axes) {
    Bytes bytes{static_cast<std::uint8_t>(pressed), static_cast<std::uint8_t>(pressed >> 8U),
                static_cast<std::uint8_t>(pressed >> 16U)};
    for (const int axis : axes) {
        bytes.push_back(static_cast<std::uint8_t>(axis));
        bytes.push_back(static_cast<std::uint8_t>(axis >> 8));
    }
    return bytes;
}

constexpr std::array kCentred{1024, 1024, 1024, 1024, 1024, 1024, 1024, 1024};

TEST(UinputLink, MakesTheJoystickOfARadio) {
    Uinput uinput;
    const auto link = opened();
    EXPECT_EQ(uinput.types, (std::vector<int>{EV_KEY, EV_ABS}));
    EXPECT_EQ(uinput.keys, buttons());
    ASSERT_EQ(uinput.axes.size(), kAxes.size());
    for (std::size_t axis = 0; axis < kAxes.size(); ++axis) {
        const uinput_abs_setup& made = uinput.axes[axis];
        EXPECT_EQ(made.code, kAxes[axis]);
        EXPECT_EQ(made.absinfo.minimum, 0);
        EXPECT_EQ(made.absinfo.maximum, 2047);
        EXPECT_EQ(made.absinfo.value, 1024);
        EXPECT_EQ(made.absinfo.flat, 0);
    }
    EXPECT_STREQ(uinput.setup.name, "stick");
    EXPECT_EQ(uinput.setup.id.bustype, BUS_VIRTUAL);
    EXPECT_EQ(uinput.setup.id.vendor, 0x7472);
    EXPECT_EQ(uinput.setup.id.product, 1);
    EXPECT_EQ(uinput.setup.id.version, 1);
    EXPECT_EQ(uinput.asked.back(), UI_DEV_CREATE);
}

TEST(UinputLink, HasANameOfAtMost79Bytes) {
    Uinput uinput;
    const auto link = opened(std::string(100, 'x'));
    EXPECT_EQ(uinput.setup.name, std::string(79, 'x'));
}

TEST(UinputLink, SaysWhyItMayNotBeMade) {
    Uinput uinput;
    uinput.opening = -EACCES;
    EXPECT_TRUE(refusal().starts_with(kCannot + "this user may not use it")) << refusal();
    uinput.opening = -ENOENT;
    EXPECT_EQ(refusal(), kCannot + "the kernel has no uinput; `sudo modprobe uinput` loads it");
    EXPECT_TRUE(uinput.asked.empty());
}

/// One request of many is refused.
TEST(UinputLink, IsNotMadeByHalves) {
    for (const int number : {EV_KEY, EV_ABS, 0x130, 0x13F, 0x2C7}) {
        Uinput uinput;
        uinput.refused_number = number;
        EXPECT_EQ(refusal(), kCannot + "Invalid argument") << number;
        EXPECT_FALSE(uinput.created) << number;
    }
    for (const int axis : {ABS_X, ABS_RX, ABS_RUDDER}) {
        Uinput uinput;
        uinput.refused_axis = axis;
        EXPECT_EQ(refusal(), kCannot + "Invalid argument") << axis;
        EXPECT_FALSE(uinput.created) << axis;
    }
    for (const unsigned long request :
         {static_cast<unsigned long>(UI_DEV_SETUP), static_cast<unsigned long>(UI_DEV_CREATE)}) {
        Uinput uinput;
        uinput.refused = {{request, EINVAL}};
        EXPECT_EQ(refusal(), kCannot + "Invalid argument") << request;
        EXPECT_FALSE(uinput.created) << request;
    }
}

TEST(UinputLink, IsMissingWhereTheKernelHasNoUinput) {
    Uinput uinput;
    EXPECT_FALSE(UinputLink::is_missing("stick"));
    uinput.opening = -ENOENT;
    EXPECT_TRUE(UinputLink::is_missing("stick"));
}

TEST(UinputLink, WritesAllOfTheFirstReport) {
    Uinput uinput;
    const auto link = opened();
    EXPECT_EQ(link->write(report(0x800001, {0, 1, 2, 3, 4, 5, 6, 2047})), WriteStatus::written);
    Events all;
    for (std::size_t axis = 0; axis < kAxes.size(); ++axis) {
        all.push_back({EV_ABS, kAxes[axis], axis == 7 ? 2047 : static_cast<int>(axis)});
    }
    for (const int button : buttons()) {
        all.push_back({EV_KEY, button, button == 0x130 || button == 0x2C7 ? 1 : 0});
    }
    all.push_back({EV_SYN, SYN_REPORT, 0});
    EXPECT_EQ(uinput.taken(), all);
}

TEST(UinputLink, WritesAllOfAFirstReportOfZeros) {
    Uinput uinput;
    const auto link = opened();
    EXPECT_EQ(link->write(report(0, {})), WriteStatus::written);
    EXPECT_EQ(uinput.taken().size(), 8U + 24 + 1);
}

TEST(UinputLink, WritesWhatChangedAndThenNothing) {
    Uinput uinput;
    const auto link = opened();
    link->write(report(0x000010, kCentred));
    uinput.taken();
    const Bytes moved = report(0x010000, {1024, 1024, 7, 1024, 1024, 1024, 1024, 300});
    EXPECT_EQ(link->write(moved), WriteStatus::written);
    EXPECT_EQ(uinput.taken(), (Events{{EV_ABS, ABS_Z, 7},
                                      {EV_ABS, ABS_RUDDER, 300},
                                      {EV_KEY, 0x134, 0},
                                      {EV_KEY, 0x2C0, 1},
                                      {EV_SYN, SYN_REPORT, 0}}));
    uinput.writes = 0;
    EXPECT_EQ(link->write(moved), WriteStatus::written);
    EXPECT_EQ(uinput.writes, 0);
}

TEST(UinputLink, TellsASingleChange) {
    Uinput uinput;
    const auto link = opened();
    link->write(report(0, kCentred));
    uinput.taken();
    EXPECT_EQ(link->write(report(1, kCentred)), WriteStatus::written);
    EXPECT_EQ(uinput.taken(), (Events{{EV_KEY, 0x130, 1}, {EV_SYN, SYN_REPORT, 0}}));
}

TEST(UinputLink, WritesAgainWhatTheKernelDidNotTake) {
    for (const auto& [failure, status] :
         {std::pair(EAGAIN, WriteStatus::busy), std::pair(EINTR, WriteStatus::busy),
          std::pair(ENODEV, WriteStatus::unavailable)}) {
        Uinput uinput;
        const auto link = opened();
        uinput.failure = failure;
        EXPECT_EQ(link->write(report(0, kCentred)), status) << failure;
        uinput.failure = 0;
        EXPECT_EQ(link->write(report(0, kCentred)), WriteStatus::written);
        EXPECT_EQ(uinput.taken().size(), 8U + 24 + 1);
    }
}

TEST(UinputLink, TakesReportsOfItsLengthOnly) {
    Uinput uinput;
    const auto link = opened();
    EXPECT_EQ(link->write(Bytes(18)), WriteStatus::unavailable);
    EXPECT_EQ(link->write(Bytes(20)), WriteStatus::unavailable);
    EXPECT_EQ(uinput.writes, 0);
}

TEST(UinputLink, HasNothingToRead) {
    const Uinput uinput;
    const auto link = opened();
    expect_nothing_to_read(*link);
}

}  // namespace
}  // namespace tribus::test::uinput_link_test
