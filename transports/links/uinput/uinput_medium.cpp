#include "transports/links/uinput/uinput_medium.h"

#include "transports/links/uinput/uinput_link.h"

namespace tribus {
namespace {

std::vector<SettingMistake> check_name(const std::string& place, const SettingValues& /*settings*/,
                                       SettingScope /*way*/, KeyUse /*key*/) {
    if (!place.empty() && place.size() <= UinputLink::kLongestName) {
        return {};
    }
    return {{{"name"}, "\"name\" is \"" + place + "\"; allowed: a name of 1 to 79 bytes"}};
}

}  // namespace

constinit const Medium kUinputMedium{
    .name = "a virtual joystick",
    .shape = WireShape::bytes,
    .only_own_protocols = true,
    .place = {.key = "name",
              .required = true,
              .help = "Name of the virtual joystick, which simulators show",
              .example = "\"tribus\""},
    .place_absent = "required on a virtual joystick",
    .check = check_name,
    .users = Users::one,
    .is_missing = UinputLink::is_missing,
    .open = [](const std::string& name,
               const LinkUse& /*use*/) { return as_link(UinputLink::open(name)); },
};

}  // namespace tribus
