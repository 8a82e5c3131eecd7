#pragma once

#include <iosfwd>
#include <string_view>

#include "app/cli/command.h"
#include "app/cli/protocol_use.h"
#include "app/wire/frames/frame_writer.h"

/// The subcommand `encode`: encodes frames to bytes, to the waveform on the wire, or to CAN frames.
namespace tribus {

/// Reads frames as JSON lines and writes each one to `results` at once. A frame without t_us
/// follows the one before after the protocol's default period. Reports unusable lines to `messages`
/// as `name:line:column: text` and skips them. Returns the exit status: 1 if there was such a line.
int encode_lines(std::istream& lines, std::string_view name, const ProtocolUse& use,
                 EncodeFormat format, std::ostream& results, std::ostream& messages,
                 std::string_view interface = kDefaultInterface);

Command encode_command();

}  // namespace tribus
