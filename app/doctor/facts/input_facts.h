#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/doctor/facts/finding.h"
#include "app/doctor/facts/kernel_files.h"
#include "app/doctor/facts/node_access.h"
#include "app/doctor/facts/port_users.h"
#include "transports/links/evdev/evdev_devices.h"

namespace tribus::doctor {

/// A gamepad, or what was named as one.
struct InputFacts {
    EvdevDeviceFacts device{};
    NodeAccess access{};
    NodeUsers users{};
    /// Why it could not be opened and taken, or an empty text; nothing if that was not tried.
    std::optional<std::string> refusal{};
};

/// The kernel's device that makes virtual joysticks.
struct UinputFacts {
    NodeAccess access{};
};

/// All gamepads and joysticks. Opens nothing.
std::vector<InputFacts> look_at_gamepads(const KernelFiles& files);

/// The input device at a path; follows links. Opens nothing.
InputFacts look_at_input(const KernelFiles& files, const std::string& device);

UinputFacts look_at_uinput(const KernelFiles& files);

/// Whether the name of a device is one of an input device, there or not.
bool names_input(const KernelFiles& files, const std::string& device);

/// Says why a configuration cannot use it. A hindrance is a problem if the user `asked_for` this
/// device, else advice. Pure.
std::vector<Finding> judge_input(const InputFacts& facts, bool asked_for);
std::vector<Finding> judge_uinput(const UinputFacts& facts, bool asked_for);

/// "gamepad \"Pad\", 4 axes, 3 buttons"; empty if it is no input device.
std::string describe(const InputFacts& facts);

/// Lines for a configuration; none if it is no gamepad.
std::vector<std::string> configuration_lines(const InputFacts& facts);

}  // namespace tribus::doctor
