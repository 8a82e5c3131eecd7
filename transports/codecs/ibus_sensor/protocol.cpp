#include <array>

#include "transports/codecs/ibus_sensor/ibus_sensor.h"

namespace tribus {
namespace {

constexpr std::array kRequestBeginnings{FrameBeginning{kSensorRequestBytes}};

std::vector<SettingMistake> check_sensor_bus(const SettingValues& /*settings*/,
                                             SettingScope scope) {
    if (scope == SettingScope::output) {
        return {{{}, "the sensor bus has no channels; its frames are made by [sensor_bus.NAME]"}};
    }
    return {};
}

}  // namespace

const Protocol kSensorBusProtocol{
    .name = kSensorBusName,
    .title = "the i.Bus sensor bus",
    .description = "FlySky i.Bus sensor bus: requests and replies",
    .line = {.baud = 115200, .parity = Parity::none, .stop_bits = 1},
    .beginnings = kRequestBeginnings,
    .settings = {},
    .check = check_sensor_bus,
};

}  // namespace tribus
