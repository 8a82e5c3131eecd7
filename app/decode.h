#pragma once

#include <functional>
#include <iosfwd>
#include <span>
#include <string>

#include "app/command.h"
#include "app/frame_printer.h"
#include "app/protocol_use.h"
#include "transports/links/recording.h"

/// The subcommand `decode`: recorded bytes or CAN frames to frames of channels.
namespace tribus {

/// Decodes a whole recording and prints heading, frames and summary; returns the exit status.
///
/// With several protocols: the one that finds the most frames reads the recording; a burst that
/// none of its frames touches, and that is exactly one frame of another protocol, is that frame.
/// Thus files that list frames of several protocols, one a line, are read whole. CAN protocols are
/// passed over. Where there are bytes but no frame of the one protocol, `talk` names those that
/// find frames there.
int decode_recording(const Recording& recording, std::span<const ProtocolUse> uses,
                     FramePrinter& printer, std::ostream& talk);

/// Decodes raw bytes as they come; `read` returns the next ones, none at the end.
int decode_stream(const std::function<std::string()>& read, const ProtocolUse& use,
                  FramePrinter& printer, std::ostream& results, std::ostream& talk);

Command decode_command();

}  // namespace tribus
