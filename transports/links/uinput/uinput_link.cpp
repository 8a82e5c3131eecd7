#include "transports/links/uinput/uinput_link.h"

#include <fcntl.h>
#include <linux/uinput.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace tribus {
namespace {

constexpr const char* kUinputDevice = "/dev/uinput";

/// As the kernel maps the axes of a USB game pad (hid-input).
constexpr std::array<std::uint16_t, kJoystickAxes.size()> kAxisCodes{
    ABS_X, ABS_Y, ABS_Z, ABS_RX, ABS_RY, ABS_RZ, ABS_THROTTLE, ABS_RUDDER};

/// And its buttons: 16 of a game pad, then those that "trigger happy" joysticks have more.
constexpr std::uint16_t button_code(std::size_t button) {
    constexpr std::size_t kOfGamepad = 16;
    return static_cast<std::uint16_t>(
        button < kOfGamepad ? BTN_GAMEPAD + button : BTN_TRIGGER_HAPPY + (button - kOfGamepad));
}

std::string uinput_problem(int error) {
    switch (error) {
        case ENOENT:
        case ENODEV:
            return "the kernel has no uinput; `sudo modprobe uinput` loads it";
        case EACCES:
        case EPERM:
            return "this user may not use it; the package's udev rule gives it to the group "
                   "uinput: join the group, and for the service see "
                   "/usr/share/doc/tribus/docs/service.md, \"Joysticks in the service\"";
        default:
            return std::strerror(error);
    }
}

bool allow_codes(int fd) {
    bool allowed = ::ioctl(fd, UI_SET_EVBIT, EV_KEY) == 0 && ::ioctl(fd, UI_SET_EVBIT, EV_ABS) == 0;
    for (std::size_t button = 0; button < kJoystickButtons; ++button) {
        allowed = allowed && ::ioctl(fd, UI_SET_KEYBIT, button_code(button)) == 0;
    }
    for (const std::uint16_t code : kAxisCodes) {
        uinput_abs_setup axis{};
        axis.code = code;
        axis.absinfo.maximum = kJoystickMost;
        axis.absinfo.value = kJoystickCentre;
        allowed = allowed && ::ioctl(fd, UI_ABS_SETUP, &axis) == 0;
    }
    return allowed;
}

bool create(int fd, const std::string& name) {
    uinput_setup setup{};
    setup.id.bustype = BUS_VIRTUAL;
    setup.id.vendor = 0x7472;  // "tr", no number of the USB consortium
    setup.id.product = 0x0001;
    setup.id.version = 1;
    std::copy_n(name.begin(), std::min(name.size(), UinputLink::kLongestName), setup.name);
    return ::ioctl(fd, UI_DEV_SETUP, &setup) == 0 && ::ioctl(fd, UI_DEV_CREATE) == 0;
}

}  // namespace

tl::expected<std::unique_ptr<UinputLink>, std::string> UinputLink::open(const std::string& name) {
    UniqueFd fd(::open(kUinputDevice, O_WRONLY | O_NONBLOCK | O_CLOEXEC));
    if (!fd.valid() || !allow_codes(fd.get()) || !create(fd.get(), name)) {
        return tl::unexpected(name + ": cannot make a joystick with " + kUinputDevice + ": " +
                              uinput_problem(errno));
    }
    return std::unique_ptr<UinputLink>(new UinputLink(std::move(fd)));
}

bool UinputLink::is_missing(const std::string& /*name*/) {
    return ::access(kUinputDevice, F_OK) != 0;
}

ReadStatus UinputLink::read(Reception& reception) {
    reception.count = 0;
    reception.full = false;
    return ReadStatus::nothing;
}

WriteStatus UinputLink::write(std::span<const std::uint8_t> frame) {
    if (frame.size() != kJoystickReportBytes) {
        return WriteStatus::unavailable;
    }
    std::array<input_event, kJoystickAxes.size() + kJoystickButtons + 1> events{};
    std::size_t count = 0;
    const auto add = [&](std::uint16_t type, std::uint16_t code, std::int32_t value) {
        events[count].type = type;
        events[count].code = code;
        events[count].value = value;
        ++count;
    };
    for (std::size_t axis = 0; axis < kAxisCodes.size(); ++axis) {
        const std::uint16_t value = joystick_axis(frame, axis);
        if (!wrote_ || value != joystick_axis(before_, axis)) {
            add(EV_ABS, kAxisCodes[axis], value);
        }
    }
    for (std::size_t button = 0; button < kJoystickButtons; ++button) {
        const bool pressed = joystick_button(frame, button);
        if (!wrote_ || pressed != joystick_button(before_, button)) {
            add(EV_KEY, button_code(button), pressed ? 1 : 0);
        }
    }
    if (count == 0) {
        return WriteStatus::written;
    }
    add(EV_SYN, SYN_REPORT, 0);
    const std::size_t bytes = count * sizeof events[0];
    if (::write(fd_.get(), events.data(), bytes) != static_cast<ssize_t>(bytes)) {
        return errno == EAGAIN || errno == EINTR ? WriteStatus::busy : WriteStatus::unavailable;
    }
    std::ranges::copy(frame, before_.begin());
    wrote_ = true;
    return WriteStatus::written;
}

}  // namespace tribus
