#pragma once

#include <string>

#include "transports/codecs/native_can/channels.h"

namespace tribus {

/// Returns the DBC text of the native CAN format: all six messages, classic and FD, made from the
/// table that the codec uses. Only the ids of `format` are used; deploy/can/native.dbc is the text
/// of the default format. Pure and reentrant.
std::string native_dbc(const CanChannelsFormat& format = {});

}  // namespace tribus
