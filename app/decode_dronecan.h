#pragma once

#include <iosfwd>
#include <span>
#include <vector>

#include "app/can_log.h"
#include "app/dronecan_printer.h"
#include "app/protocol_use.h"
#include "transports/links/recording.h"

/// `decode` of DroneCAN: all transfers of a bus, not only those that carry channels.
namespace tribus {

inline constexpr const char* kDroneCanName = "dronecan";

/// Whether a log is one of DroneCAN: most of its transfers are whole and of known types.
bool is_dronecan(const Recording& recording);

/// Explains a whole log and prints heading, transfers and summary; returns the exit status.
int decode_dronecan_recording(const Recording& recording, TransferPrinter& printer);

/// Explains a log as its lines come, as decode_can_stream does.
int decode_dronecan_stream(const CanLogSource& source, TransferPrinter& printer,
                           std::ostream& results, std::ostream& talk);

/// All but DroneCAN: what is not there as a whole cannot be told from other protocols.
std::vector<ProtocolUse> without_dronecan(std::span<const ProtocolUse> uses);

/// Whether it is DroneCAN and nothing else is in it that any of `uses` reads.
bool only_dronecan(const Recording& recording, std::span<const ProtocolUse> uses);

}  // namespace tribus
