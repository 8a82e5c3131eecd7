#pragma once

#include <cstdint>
#include <iosfwd>
#include <span>

#include "app/can_log.h"
#include "app/frame_printer.h"
#include "app/protocol_use.h"
#include "transports/links/recording.h"

/// `decode` of CAN protocols, over logs of candump.
namespace tribus {

/// The most snapshots of channels that one of the protocols finds.
std::uint64_t most_snapshots(std::span<const ProtocolUse> uses, const Recording& recording);

/// Decodes a whole log and prints heading, frames and summary; returns the exit status. Of several
/// protocols the one that finds the most snapshots reads it.
int decode_can_recording(const Recording& recording, std::span<const ProtocolUse> uses,
                         FramePrinter& printer, std::ostream& talk);

/// Decodes a log as its lines come. Lines that cannot be used are reported and left out; returns
/// the exit status, 1 if there was any, or where a second interface shows up unasked.
int decode_can_stream(const CanLogSource& source, const ProtocolUse& use, FramePrinter& printer,
                      std::ostream& results, std::ostream& talk);

}  // namespace tribus
