#include "app/cli/line_use.h"

#include <utility>

#include <fmt/format.h>

#include "core/quotes.h"
#include "transports/codecs/ibus_sensor/ibus_sensor.h"

namespace tribus {
bool is_device_path(std::string_view name) {
    return name.find('/') != std::string_view::npos;
}

tl::expected<ProtocolUse, std::string> serial_use(const std::string& protocol,
                                                  const std::string& baud) {
    const std::string allowed =
        fmt::format("allowed: {}, {}", protocol_list(WireShape::bytes), kSensorBusName);
    if (protocol.empty()) {
        return tl::unexpected(fmt::format(
            "a serial device needs --protocol, which sets rate, parity and stop bits; {}",
            allowed));
    }
    GivenSettings given;
    if (!baud.empty()) {
        given.emplace("baud", baud);
    }
    // The sensor bus has no channels; its line is that of i.Bus.
    auto uses = choose_protocols(protocol == kSensorBusName ? "ibus" : protocol,
                                 SettingScope::input, given);
    if (!uses) {
        return tl::unexpected(std::move(uses.error()));
    }
    if (protocol == "auto" || uses->front().protocol->shape != WireShape::bytes) {
        return tl::unexpected(fmt::format("--protocol {} does not run on a serial line; {}",
                                          in_quotes(protocol), allowed));
    }
    return std::move(uses->front());
}

}  // namespace tribus
