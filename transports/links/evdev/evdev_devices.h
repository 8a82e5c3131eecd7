#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

/// The input devices of this machine, as the kernel shows them without being opened.
namespace tribus {

struct EvdevDeviceFacts {
    std::string event{};  ///< "event3"
    std::string node{};   ///< "/dev/input/event3"
    /// Best name for a configuration: below /dev/input/by-id, else by-path, else the node.
    std::string device{};
    std::string name{};    ///< the maker's: "Xbox Wireless Controller"
    std::string unique{};  ///< address of a Bluetooth device, or serial number; may be empty
    std::vector<std::uint16_t> axes{};     ///< codes of linux/input-event-codes.h, ascending
    std::vector<std::uint16_t> buttons{};  ///< the same, keys left out

    /// It has sticks and the buttons of a gamepad or joystick, and is no touch screen or tablet.
    bool is_gamepad() const;
    /// Its name stays when something else is plugged in.
    bool has_stable_name() const { return device != node; }
};

/// All input devices, by their numbers. `root` is "/" except in tests. May block.
std::vector<EvdevDeviceFacts> find_evdev_devices(const std::filesystem::path& root = "/");

/// The device at a path; follows links such as those in /dev/input/by-id. If it is none
/// that gives events, all but `node` and `device` is empty. May block.
EvdevDeviceFacts look_at_evdev_device(const std::string& path,
                                      const std::filesystem::path& root = "/");

}  // namespace tribus
