#pragma once

#include <string>
#include <string_view>

#include <tl/expected.hpp>

#include "app/protocol_use.h"

/// What `record` and `replay` must know of a port.
namespace tribus {

/// A path of a serial device, not the name of a CAN interface.
bool is_device_path(std::string_view name);

/// The line that a protocol on serial ports wants, at another rate where one is given. The error
/// says what is allowed.
tl::expected<ProtocolUse, std::string> serial_use(const std::string& protocol,
                                                  const std::string& baud);

}  // namespace tribus
