#pragma once

#include <iosfwd>
#include <span>
#include <vector>

#include "app/cli/protocol_use.h"
#include "app/wire/dronecan/dronecan_printer.h"
#include "app/wire/frames/can_log.h"
#include "transports/recordings/recording.h"

/// `decode` for DroneCAN: all transfers of a bus, not only those with channels.
namespace tribus {

inline constexpr const char* kDroneCanName = "dronecan";

/// True if most transfers of the log are complete and of known types.
bool is_dronecan(const Recording& recording);

/// Decodes a whole log and prints heading, transfers and summary. Returns the exit status.
int decode_dronecan_recording(const Recording& recording, TransferPrinter& printer);

/// Decodes a log while its lines arrive, like decode_can_stream.
int decode_dronecan_stream(const CanLogSource& source, TransferPrinter& printer,
                           std::ostream& results, std::ostream& messages);

/// All protocols except DroneCAN, which cannot be told from others before the whole log is there.
std::vector<ProtocolUse> without_dronecan(std::span<const ProtocolUse> uses);

/// True if the log is DroneCAN and none of `uses` finds anything else in it.
bool only_dronecan(const Recording& recording, std::span<const ProtocolUse> uses);

}  // namespace tribus
