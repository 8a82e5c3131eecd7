#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "core/pulse.h"
#include "transports/codecs/dbc/map.h"

/// Reads and writes one channel in the data of a frame. `data` is a whole frame of the channel's
/// message. Pure and reentrant; no heap.
namespace tribus {

/// Returns nothing if the signal has no value: a code, a value outside its range, or contradicting
/// direction signals.
std::optional<Pulse> read_dbc_channel(const DbcChannel& channel,
                                      std::span<const std::uint8_t> data);

/// Why a signal with these bits has no value, for people: "65535 is outside of [800|2200]". Writes
/// to the front of `text`, cut to its size; returns the length.
std::size_t write_dbc_absence(const DbcChannel& channel, std::uint64_t bits, std::span<char> text);

/// `pulse`: nothing for an absent channel, which is written as a code, or as 1500 us if the signal
/// has no code. In `failsafe` the code for an error is preferred.
void write_dbc_channel(const DbcChannel& channel, std::optional<Pulse> pulse, bool failsafe,
                       std::span<std::uint8_t> data);

/// Writes a number in the unit of the signal, limited to what the signal and the file allow, and
/// never as one of its codes. Returns false if there is no number and no code for that.
bool write_dbc_value(const DbcValue& value, std::optional<double> number,
                     std::span<std::uint8_t> data);

}  // namespace tribus
