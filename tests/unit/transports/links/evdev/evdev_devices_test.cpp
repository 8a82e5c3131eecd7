#include "transports/links/evdev/evdev_devices.h"

#include <linux/input-event-codes.h>

#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/input_tree.h"

/// Input devices in a folder with the files that the kernel and udev make.
namespace tribus::test::evdev_devices_test {
namespace {

using Codes = std::vector<std::uint16_t>;

TEST(EvdevDevices, AreFoundByTheirNumbersWithTheirNames) {
    const InputTree tree;
    tree.add_pad("event10", "Pad B");
    tree.add_keyboard("event2");
    tree.write("sys/class/input/js0/device/name", "Pad B");
    tree.write("sys/class/input/mice/uevent", "");
    const auto devices = find_evdev_devices(tree.root());
    ASSERT_EQ(devices.size(), 2U);
    EXPECT_EQ(devices[0].event, "event2");
    EXPECT_FALSE(devices[0].is_gamepad());
    EXPECT_EQ(devices[1].node, "/dev/input/event10");
    EXPECT_EQ(devices[1].name, "Pad B");
    EXPECT_TRUE(devices[1].is_gamepad());
    EXPECT_EQ(devices[1].axes, (Codes{ABS_X, ABS_Y, ABS_RX, ABS_RY}));
    EXPECT_EQ(devices[1].buttons, (Codes{BTN_SOUTH, BTN_EAST, BTN_TL}));
}

TEST(EvdevDevices, AreNamedByIdBeforeByPathAndByTheirNumberOtherwise) {
    const InputTree tree;
    tree.add_pad("event3", "Pad");
    EXPECT_EQ(find_evdev_devices(tree.root())[0].device, "/dev/input/event3");
    EXPECT_FALSE(find_evdev_devices(tree.root())[0].has_stable_name());
    tree.plain_link("dev/input/by-path/pci-0000:00-usb-0:1.2:1.0-event-joystick", "../event3");
    tree.plain_link("dev/input/by-path/pci-0000:00-usb-0:1.2:1.0-joystick", "../js0");
    EXPECT_EQ(find_evdev_devices(tree.root())[0].device,
              "/dev/input/by-path/pci-0000:00-usb-0:1.2:1.0-event-joystick");
    tree.plain_link("dev/input/by-id/usb-Pad-event-joystick", "../event3");
    tree.plain_link("dev/input/by-id/usb-Other-event-joystick", "../event30");
    EXPECT_EQ(find_evdev_devices(tree.root())[0].device, "/dev/input/by-id/usb-Pad-event-joystick");
    EXPECT_TRUE(find_evdev_devices(tree.root())[0].has_stable_name());
}

TEST(EvdevDevices, HaveTheFirstOfSeveralNames) {
    const InputTree tree;
    tree.add_pad("event3", "Pad");
    for (const std::string name : {"a", "b", "c", "d"}) {
        tree.plain_link("dev/input/by-id/" + name, "../event3");
    }
    EXPECT_EQ(find_evdev_devices(tree.root())[0].device, "/dev/input/by-id/a");
}

TEST(EvdevDevices, HaveNamesOfEventAndANumber) {
    const InputTree tree;
    for (const std::string name : {"event", "eventx", "event1x", "xevent1", "js1"}) {
        tree.add_pad(name, "None");
        EXPECT_EQ(look_at_evdev_device("/dev/input/" + name, tree.root()).event, "") << name;
    }
    tree.write("dev/input/event9", "");
    EXPECT_EQ(look_at_evdev_device("/dev/input/event9", tree.root()).event, "")
        << "the kernel knows none";
    EXPECT_TRUE(find_evdev_devices(tree.root()).empty());
}

TEST(EvdevDevices, HaveTheirSerialNumberAndAllTheirCodes) {
    const InputTree tree;
    tree.add("event0", "Wide", {ABS_X, ABS_MT_SLOT, ABS_MAX}, {KEY_A, BTN_MISC, KEY_MAX});
    tree.write("sys/class/input/event0/device/uniq", "0a:1b\n");
    const auto devices = find_evdev_devices(tree.root());
    ASSERT_EQ(devices.size(), 1U);
    EXPECT_EQ(devices[0].unique, "0a:1b");
    EXPECT_EQ(devices[0].axes, (Codes{ABS_X, ABS_MT_SLOT, ABS_MAX}));
    EXPECT_EQ(devices[0].buttons, (Codes{BTN_MISC, KEY_MAX}));
}

TEST(EvdevDevices, AreLookedAtByAnyNameAndKeepThatOfAPerson) {
    const InputTree tree;
    tree.add_pad("event3", "Pad");
    tree.plain_link("dev/input/by-id/usb-Pad-event-joystick", "../event3");
    tree.plain_link("dev/input/pad", "event3");
    EXPECT_EQ(look_at_evdev_device("/dev/input/event3", tree.root()).device,
              "/dev/input/by-id/usb-Pad-event-joystick");
    const auto pad = look_at_evdev_device("/dev/input/pad", tree.root());
    EXPECT_EQ(pad.device, "/dev/input/pad");
    EXPECT_EQ(pad.node, "/dev/input/event3");
    EXPECT_EQ(pad.name, "Pad");
    for (const char* other : {"/dev/input/js0", "/dev/ttyUSB0", "/dev/input/event4"}) {
        EXPECT_EQ(look_at_evdev_device(other, tree.root()).event, "") << other;
    }
}

TEST(EvdevDevices, AreNoGamepadsIfTheyOnlyHaveSomeOfWhatThoseHave) {
    const auto is_gamepad = [](const Codes& axes, const Codes& buttons) {
        return EvdevDeviceFacts{.axes = axes, .buttons = buttons}.is_gamepad();
    };
    EXPECT_TRUE(is_gamepad({ABS_X, ABS_Y}, {BTN_TRIGGER})) << "a joystick";
    EXPECT_TRUE(is_gamepad({ABS_HAT0X}, {BTN_SOUTH})) << "a pad with a cross only";
    EXPECT_TRUE(is_gamepad({ABS_WHEEL, ABS_GAS}, {BTN_TRIGGER_HAPPY2})) << "a wheel";
    EXPECT_FALSE(is_gamepad({ABS_X, ABS_Y, ABS_Z}, {})) << "an accelerometer";
    EXPECT_FALSE(is_gamepad({}, {BTN_SOUTH})) << "buttons alone";
    EXPECT_FALSE(is_gamepad({ABS_X, ABS_Y}, {BTN_LEFT})) << "a tablet's mouse";
    EXPECT_FALSE(is_gamepad({ABS_X, ABS_Y}, {BTN_SOUTH, BTN_TOUCH})) << "a touch pad";
    EXPECT_FALSE(is_gamepad({ABS_VOLUME}, {BTN_SOUTH})) << "a remote control";
}

TEST(EvdevDevices, AreGamepadsByTheCodesOfGamepads) {
    const auto has_stick = [](int axis) {
        return EvdevDeviceFacts{.axes = {static_cast<std::uint16_t>(axis)}, .buttons = {BTN_SOUTH}}
            .is_gamepad();
    };
    for (const int axis : {ABS_X, ABS_BRAKE, ABS_HAT0X}) {
        EXPECT_TRUE(has_stick(axis)) << axis;
    }
    for (const int axis : {ABS_BRAKE + 1, ABS_HAT0X - 1, ABS_HAT0Y}) {
        EXPECT_FALSE(has_stick(axis)) << axis;
    }
    const auto with = [](int button) {
        return EvdevDeviceFacts{.axes = {ABS_X}, .buttons = {static_cast<std::uint16_t>(button)}}
            .is_gamepad();
    };
    for (const int button : {BTN_JOYSTICK, BTN_THUMBR, BTN_TRIGGER_HAPPY, BTN_TRIGGER_HAPPY40}) {
        EXPECT_TRUE(with(button)) << button;
    }
    for (const int button :
         {BTN_JOYSTICK - 1, BTN_THUMBR + 1, BTN_TRIGGER_HAPPY - 1, BTN_TRIGGER_HAPPY40 + 1}) {
        EXPECT_FALSE(with(button)) << button;
    }
    const auto beside = [](int button) {
        return EvdevDeviceFacts{.axes = {ABS_X},
                                .buttons = {BTN_SOUTH, static_cast<std::uint16_t>(button)}}
            .is_gamepad();
    };
    for (const int button : {BTN_DIGI, BTN_TOOL_QUADTAP}) {
        EXPECT_FALSE(beside(button)) << button << ": fingers and pens";
    }
    EXPECT_TRUE(beside(BTN_TOOL_QUADTAP + 1));
}

}  // namespace
}  // namespace tribus::test::evdev_devices_test
