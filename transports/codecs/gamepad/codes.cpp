#include "transports/codecs/gamepad/codes.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace tribus {
namespace {

struct InputCode {
    std::string_view name;
    std::uint16_t code = 0;
};

// The names and numbers of linux/input-event-codes.h, those that gamepads and joysticks have.
constexpr std::array kAxisNames{
    InputCode{"ABS_X", 0x00},        InputCode{"ABS_Y", 0x01},      InputCode{"ABS_Z", 0x02},
    InputCode{"ABS_RX", 0x03},       InputCode{"ABS_RY", 0x04},     InputCode{"ABS_RZ", 0x05},
    InputCode{"ABS_THROTTLE", 0x06}, InputCode{"ABS_RUDDER", 0x07}, InputCode{"ABS_WHEEL", 0x08},
    InputCode{"ABS_GAS", 0x09},      InputCode{"ABS_BRAKE", 0x0A},  InputCode{"ABS_HAT0X", 0x10},
    InputCode{"ABS_HAT0Y", 0x11},    InputCode{"ABS_HAT1X", 0x12},  InputCode{"ABS_HAT1Y", 0x13},
};
constexpr std::array kButtonNames{
    InputCode{"BTN_TRIGGER", 0x120},   InputCode{"BTN_THUMB", 0x121},
    InputCode{"BTN_THUMB2", 0x122},    InputCode{"BTN_TOP", 0x123},
    InputCode{"BTN_TOP2", 0x124},      InputCode{"BTN_PINKIE", 0x125},
    InputCode{"BTN_BASE", 0x126},      InputCode{"BTN_BASE2", 0x127},
    InputCode{"BTN_BASE3", 0x128},     InputCode{"BTN_BASE4", 0x129},
    InputCode{"BTN_BASE5", 0x12A},     InputCode{"BTN_BASE6", 0x12B},
    InputCode{"BTN_DEAD", 0x12F},      InputCode{"BTN_SOUTH", 0x130},
    InputCode{"BTN_EAST", 0x131},      InputCode{"BTN_C", 0x132},
    InputCode{"BTN_NORTH", 0x133},     InputCode{"BTN_WEST", 0x134},
    InputCode{"BTN_Z", 0x135},         InputCode{"BTN_TL", 0x136},
    InputCode{"BTN_TR", 0x137},        InputCode{"BTN_TL2", 0x138},
    InputCode{"BTN_TR2", 0x139},       InputCode{"BTN_SELECT", 0x13A},
    InputCode{"BTN_START", 0x13B},     InputCode{"BTN_MODE", 0x13C},
    InputCode{"BTN_THUMBL", 0x13D},    InputCode{"BTN_THUMBR", 0x13E},
    InputCode{"BTN_DPAD_UP", 0x220},   InputCode{"BTN_DPAD_DOWN", 0x221},
    InputCode{"BTN_DPAD_LEFT", 0x222}, InputCode{"BTN_DPAD_RIGHT", 0x223},
};

// BTN_TRIGGER_HAPPY1 to BTN_TRIGGER_HAPPY40: further buttons of joysticks.
constexpr std::string_view kFurtherButtons = "BTN_TRIGGER_HAPPY";
constexpr std::uint16_t kFirstFurtherButton = 0x2C0;
constexpr std::uint16_t kCountOfFurtherButtons = 40;

std::string further_button(std::size_t number) {
    return std::string(kFurtherButtons) + std::to_string(number);
}

template <std::size_t count>
std::optional<std::uint16_t> code_of(std::string_view name,
                                     const std::array<InputCode, count>& codes) {
    const auto found = std::ranges::find(codes, name, &InputCode::name);
    return found == codes.end() ? std::nullopt : std::optional(found->code);
}

template <std::size_t count>
std::string_view name_of_code(std::uint16_t code, const std::array<InputCode, count>& codes) {
    const auto found = std::ranges::find(codes, code, &InputCode::code);
    return found == codes.end() ? std::string_view() : found->name;
}

}  // namespace

std::optional<std::uint16_t> gamepad_axis_code(std::string_view name) {
    return code_of(name, kAxisNames);
}

std::optional<std::uint16_t> gamepad_button_code(std::string_view name) {
    for (std::uint16_t i = 0; i < kCountOfFurtherButtons; ++i) {
        if (name == further_button(i + 1U)) {
            return static_cast<std::uint16_t>(kFirstFurtherButton + i);
        }
    }
    return code_of(name, kButtonNames);
}

std::string_view gamepad_axis_name(std::uint16_t code) {
    return name_of_code(code, kAxisNames);
}

std::string gamepad_button_name(std::uint16_t code) {
    const bool further =
        code >= kFirstFurtherButton && code < kFirstFurtherButton + kCountOfFurtherButtons;
    return further ? further_button(code - kFirstFurtherButton + 1U)
                   : std::string(name_of_code(code, kButtonNames));
}

}  // namespace tribus
