#include "transports/links/evdev/evdev_medium.h"

#include <array>
#include <filesystem>

#include "transports/links/device_path.h"
#include "transports/links/evdev/evdev_link.h"
#include "transports/links/serial/serial_medium.h"

namespace tribus {
namespace {

constexpr std::array kEvdevSettings{
    Setting{.key = "grab",
            .type = SettingType::boolean,
            .fallback = "true",
            .scope = SettingScope::input,
            .help = "Whether no other program, such as a desktop, gets the device's events "
                    "meanwhile. With `false` nothing tells that another program has taken it for "
                    "itself",
            .example = "false"},
};

bool is_absent(const std::string& device) {
    std::error_code error;
    return !std::filesystem::exists(device, error);
}

}  // namespace

constinit const Medium kEvdevMedium{
    .name = "an input device",
    .shape = WireShape::bytes,
    .only_own_protocols = true,
    .place = {.key = kDeviceSetting.key,
              .required = true,
              .help = "Input device, best by a stable name under /dev/input/by-id",
              .example = "\"/dev/input/by-id/usb-pad-event-joystick\""},
    .place_absent = "required on an input device",
    .place_is_path = true,
    .settings = kEvdevSettings,
    .has_datagrams = true,
    .users = Users::one,
    .silence = {.nothing = "nothing from it yet; check that it is switched on and connected",
                .no_frame = "what comes is no report of a gamepad; check that it is one",
                .not_good = "let go of its sticks, then press a button; and hold its dead man's "
                            "button, if it has one",
                .doctor = "looks at it"},
    .is_missing = is_absent,
    .identity = device_identity,
    .open =
        [](const std::string& device, const LinkUse& use) {
            return as_link(EvdevLink::open(device, use.settings.get_or("grab", true)));
        },
};

}  // namespace tribus
