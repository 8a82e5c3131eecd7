#include "transports/registry/registry.h"

#include <array>

#include "transports/codecs/dbc/dbc.h"
#include "transports/codecs/dronecan/dronecan.h"
#include "transports/codecs/ibus/ibus.h"
#include "transports/codecs/native_can/channels.h"
#include "transports/codecs/native_can/sensors.h"
#include "transports/codecs/sbus/sbus.h"

namespace tribus {

std::span<const Protocol* const> protocols() {
    static constexpr std::array kProtocols{
        &kIbusProtocol, &kSbusProtocol,    &kCanProtocol,
        &kDbcProtocol,  &kSensorsProtocol, &kDroneCanProtocol,
    };
    return kProtocols;
}

const Protocol* find_protocol(std::string_view name) {
    for (const Protocol* protocol : protocols()) {
        if (protocol->name == name) {
            return protocol;
        }
    }
    return nullptr;
}

}  // namespace tribus
