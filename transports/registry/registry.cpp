#include "transports/registry/registry.h"

#include <algorithm>
#include <array>
#include <iterator>

#include "transports/codecs/dbc/dbc.h"
#include "transports/codecs/dronecan/dronecan.h"
#include "transports/codecs/ibus/ibus.h"
#include "transports/codecs/native_can/channels.h"
#include "transports/codecs/native_can/sensors.h"
#include "transports/codecs/sbus/sbus.h"
#include "transports/links/can/can_medium.h"
#include "transports/links/serial/serial_medium.h"

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

std::span<const Medium* const> media() {
    static constexpr std::array kMedia{&kSerialMedium, &kCanMedium};
    return kMedia;
}

std::vector<const Medium*> media_for(WireShape shape) {
    std::vector<const Medium*> found;
    std::ranges::copy_if(media(), std::back_inserter(found),
                         [shape](const Medium* medium) { return medium->shape == shape; });
    return found;
}

}  // namespace tribus
