#pragma once

#include <iosfwd>
#include <string_view>

#include "app/command.h"
#include "app/frame_writer.h"
#include "app/protocol_use.h"

/// The subcommand `encode`: frames to bytes, to the waveform on the wire, or to CAN frames.
namespace tribus {

/// Reads frames as JSON lines and writes each to `results` as soon as it is read.
/// Frames without t_us follow the one ahead after the protocol's default period. Lines that cannot
/// be used are reported as `name:line:column: text` and left out. Returns the exit status: 1 if
/// there was any.
int encode_lines(std::istream& lines, std::string_view name, const ProtocolUse& use,
                 EncodeFormat format, std::ostream& results, std::ostream& talk,
                 std::string_view interface = kDefaultInterface);

Command encode_command();

}  // namespace tribus
