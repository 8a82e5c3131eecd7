#pragma once

#include <string>
#include <string_view>

#include <tl/expected.hpp>

#include "app/cli/command.h"
#include "app/cli/protocol_use.h"

/// Ports of `record` and `replay`.
namespace tribus {

/// True for the path of a serial device, false for the name of a CAN interface.
bool is_device_path(std::string_view name);

/// The line settings of a serial protocol, with another rate if `baud` is not empty. The error says
/// what is allowed.
tl::expected<ProtocolUse, std::string> serial_use(const std::string& protocol,
                                                  const std::string& baud);

/// `--protocol` and `--baud` of a command that opens a serial device.
CommandOption line_protocol_option(std::string& protocol);
CommandOption line_baud_option(std::string& baud);

}  // namespace tribus
