#pragma once

#include <cstdint>
#include <iosfwd>
#include <string_view>

#include "app/protocol_use.h"

namespace CLI {
class App;
}

/// The subcommand `encode`: frames to bytes, or to the waveform on the wire.
namespace tribus {

enum class EncodeFormat : std::uint8_t { binary, hex, timed, vcd };

/// Reads frames as JSON lines and writes the bytes of each to `results` as soon as it is read.
/// Frames without t_us follow the one ahead after the protocol's default period. Lines that cannot
/// be used are reported as `name:line:column: text` and left out. Returns the exit status: 1 if
/// there was any.
int encode_lines(std::istream& lines, std::string_view name, const ProtocolUse& use,
                 EncodeFormat format, std::ostream& results, std::ostream& talk);

void add_encode_command(CLI::App& app, int& status);

}  // namespace tribus
