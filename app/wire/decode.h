#pragma once

#include <functional>
#include <iosfwd>
#include <span>
#include <string>

#include "app/cli/command.h"
#include "app/cli/protocol_use.h"
#include "app/wire/frames/frame_printer.h"
#include "transports/recordings/recording.h"

/// The subcommand `decode`: decodes recorded bytes or CAN frames to channel frames.
namespace tribus {

/// Decodes a whole recording and prints heading, frames and summary. Returns the exit status. Skips
/// CAN protocols.
///
/// If there are several protocols, the one that finds the most frames decodes the recording. A
/// burst that none of its frames touches and that is exactly one frame of another protocol is
/// decoded as that frame; so a file that lists frames of several protocols, one a line, is decoded
/// completely. If there are bytes but no frame of the only protocol, `messages` names protocols
/// that find frames.
int decode_recording(const Recording& recording, std::span<const ProtocolUse> uses,
                     FramePrinter& printer, std::ostream& messages);

/// Decodes raw bytes as they arrive. `read` returns the next bytes, none at the end.
int decode_stream(const std::function<std::string()>& read, const ProtocolUse& use,
                  FramePrinter& printer, std::ostream& results, std::ostream& messages);

Command decode_command();

}  // namespace tribus
