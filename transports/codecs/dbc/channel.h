#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "core/pulse.h"
#include "transports/codecs/dbc/map.h"

/// One channel in the data of a frame. Pure and reentrant; no heap. `data` is a whole frame of the
/// channel's message.
namespace tribus {

/// Nothing where the signal says that it has no value.
std::optional<Pulse> read_dbc_channel(const DbcChannel& channel,
                                      std::span<const std::uint8_t> data);

/// Nothing: the code that says so, or the centre where there is no code.
void write_dbc_channel(const DbcChannel& channel, std::optional<Pulse> pulse, bool failsafe,
                       std::span<std::uint8_t> data);

/// A number in the unit of the signal, cut to what the signal and the file allow, never one of its
/// codes. False where there is none and no code to say so.
bool write_dbc_value(const DbcValue& value, std::optional<double> number,
                     std::span<std::uint8_t> data);

}  // namespace tribus
