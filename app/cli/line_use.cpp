#include "app/cli/line_use.h"

#include <utility>

#include <fmt/format.h>

#include "core/quotes.h"
#include "transports/links/serial/serial_medium.h"
#include "transports/registry/registry.h"

namespace tribus {
bool is_device_path(std::string_view name) {
    return name.find('/') != std::string_view::npos;
}

tl::expected<ProtocolUse, std::string> serial_use(const std::string& protocol,
                                                  const std::string& baud) {
    const std::string allowed = "allowed: " + protocol_list(kSerialMedium);
    if (protocol.empty()) {
        return tl::unexpected(fmt::format(
            "a serial device needs --protocol, which sets rate, parity and stop bits; {}",
            allowed));
    }
    GivenSettings given;
    if (!baud.empty()) {
        given.emplace("baud", baud);
    }
    auto uses = choose_protocols(protocol, SettingScope::input, given);
    if (!uses) {
        return tl::unexpected(std::move(uses.error()));
    }
    if (protocol == "auto" || !carries(kSerialMedium, *uses->front().protocol)) {
        return tl::unexpected(fmt::format("--protocol {} does not run on a serial line; {}",
                                          in_quotes(protocol), allowed));
    }
    return std::move(uses->front());
}

CommandOption line_protocol_option(std::string& protocol) {
    return {.name = "--protocol",
            .value = &protocol,
            .help = "Protocol of a serial line, which sets rate, parity and stop bits: " +
                    protocol_list(kSerialMedium),
            .value_name = "PROTOCOL",
            .offers = [] { return protocol_names_on(kSerialMedium); }};
}

CommandOption line_baud_option(std::string& baud) {
    return {.name = "--baud",
            .value = &baud,
            .help = "Bit rate, if it is not the protocol's own",
            .value_name = "NUMBER"};
}

}  // namespace tribus
