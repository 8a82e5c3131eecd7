#include "tests/lab/input_devices.h"

#include <fcntl.h>
#include <linux/uinput.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <array>
#include <climits>
#include <cstddef>
#include <filesystem>

#include <gtest/gtest.h>

#include "tests/lab/shell.h"

namespace tribus::test {
namespace {

template <std::size_t count>
std::vector<int> codes_in(const std::array<unsigned char, count>& bits) {
    std::vector<int> codes;
    for (std::size_t code = 0; code < count * CHAR_BIT; ++code) {
        if ((bits[code / CHAR_BIT] >> code % CHAR_BIT & 1) != 0) {
            codes.push_back(static_cast<int>(code));
        }
    }
    return codes;
}

}  // namespace

std::string event_device(const std::string& name) {
    std::error_code error;
    for (const auto& entry : std::filesystem::directory_iterator("/sys/class/input", error)) {
        const std::string event = entry.path().filename();
        if (event.starts_with("event") && read_file(entry.path() / "device/name") == name) {
            return "/dev/input/" + event;
        }
    }
    return {};
}

InputReader::InputReader(const std::string& device)
    : fd_(::open(device.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC)) {}

input_absinfo InputReader::range(int code) const {
    input_absinfo range{};
    EXPECT_GE(::ioctl(fd_.get(), EVIOCGABS(static_cast<unsigned>(code)), &range), 0) << code;
    return range;
}

int InputReader::axis(int code) const {
    return range(code).value;
}

bool InputReader::pressed(int code) const {
    std::array<unsigned char, KEY_CNT / CHAR_BIT> bits{};
    EXPECT_GE(::ioctl(fd_.get(), EVIOCGKEY(sizeof bits), bits.data()), 0);
    const auto at = static_cast<std::size_t>(code);
    return (bits[at / CHAR_BIT] >> at % CHAR_BIT & 1) != 0;
}

std::vector<int> InputReader::axes() const {
    std::array<unsigned char, ABS_CNT / CHAR_BIT> bits{};
    EXPECT_GE(::ioctl(fd_.get(), EVIOCGBIT(EV_ABS, sizeof bits), bits.data()), 0);
    return codes_in(bits);
}

std::vector<int> InputReader::buttons() const {
    std::array<unsigned char, KEY_CNT / CHAR_BIT> bits{};
    EXPECT_GE(::ioctl(fd_.get(), EVIOCGBIT(EV_KEY, sizeof bits), bits.data()), 0);
    return codes_in(bits);
}

bool InputReader::grab() const {
    return ::ioctl(fd_.get(), EVIOCGRAB, 1) == 0;
}

VirtualGamepad::VirtualGamepad(const std::string& name, const std::vector<int>& buttons)
    : fd_(::open("/dev/uinput", O_WRONLY | O_NONBLOCK | O_CLOEXEC)) {
    const int fd = fd_.get();
    EXPECT_EQ(::ioctl(fd, UI_SET_EVBIT, EV_KEY), 0);
    EXPECT_EQ(::ioctl(fd, UI_SET_EVBIT, EV_ABS), 0);
    for (const int button : buttons) {
        EXPECT_EQ(::ioctl(fd, UI_SET_KEYBIT, button), 0);
    }
    for (const int axis : {ABS_X, ABS_Y, ABS_RX, ABS_RY}) {
        uinput_abs_setup setup{};
        setup.code = static_cast<std::uint16_t>(axis);
        setup.absinfo.minimum = -100;
        setup.absinfo.maximum = 100;
        EXPECT_EQ(::ioctl(fd, UI_ABS_SETUP, &setup), 0);
    }
    uinput_setup setup{};
    setup.id.bustype = BUS_USB;
    setup.id.vendor = 1;
    setup.id.product = 1;
    name.copy(setup.name, sizeof setup.name - 1);
    EXPECT_EQ(::ioctl(fd, UI_DEV_SETUP, &setup), 0);
    EXPECT_EQ(::ioctl(fd, UI_DEV_CREATE), 0);
    device_ = event_device(name);
    EXPECT_FALSE(device_.empty()) << "the kernel has no evdev";
}

void VirtualGamepad::change(const std::vector<Change>& changes) const {
    std::vector<input_event> events;
    for (const Change& change : changes) {
        input_event event{};
        event.type = static_cast<std::uint16_t>(change.type);
        event.code = static_cast<std::uint16_t>(change.code);
        event.value = change.value;
        events.push_back(event);
    }
    events.emplace_back();
    const std::size_t bytes = events.size() * sizeof events[0];
    EXPECT_EQ(::write(fd_.get(), events.data(), bytes), static_cast<ssize_t>(bytes));
}

}  // namespace tribus::test
