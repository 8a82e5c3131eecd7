#pragma once

#include <cstdint>
#include <iosfwd>
#include <span>

#include "app/cli/protocol_use.h"
#include "app/wire/frames/can_log.h"
#include "app/wire/frames/frame_printer.h"
#include "transports/recordings/recording.h"

/// `decode` for CAN protocols, from candump logs.
namespace tribus {

/// The largest number of channel snapshots that one of the protocols finds.
std::uint64_t most_snapshots(std::span<const ProtocolUse> uses, const Recording& recording);

/// Decodes a whole log and prints heading, frames and summary. Returns the exit status. Of several
/// protocols, the one that finds the most snapshots decodes the log.
int decode_can_recording(const Recording& recording, std::span<const ProtocolUse> uses,
                         FramePrinter& printer, std::ostream& messages);

/// Decodes a log while its lines arrive. Reports and skips lines that cannot be used. Returns the
/// exit status: 1 if there was such a line, or a second interface that was not asked for.
int decode_can_stream(const CanLogSource& source, const ProtocolUse& use, FramePrinter& printer,
                      std::ostream& results, std::ostream& messages);

}  // namespace tribus
