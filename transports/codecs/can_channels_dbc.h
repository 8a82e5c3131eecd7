#pragma once

#include <string>

#include "transports/codecs/can_channels.h"

namespace tribus {

/// The DBC text of the native CAN format: all six messages, classic and FD, from the table that the
/// codec itself uses. Of `format` it takes the ids; deploy/can/native.dbc is that of the defaults.
/// Pure and reentrant.
std::string native_dbc(const CanChannelsFormat& format = {});

}  // namespace tribus
