#pragma once

#include <functional>
#include <iosfwd>
#include <span>
#include <string>
#include <string_view>

#include <tl/expected.hpp>

#include "app/frame_printer.h"
#include "app/protocol_use.h"
#include "transports/links/recording.h"

/// `decode` of CAN protocols, over logs of candump.
namespace tribus {

/// The frames of one interface of a log; `interface` empty: of the only one that it names. The
/// error, `file: text`, lists those that it names.
tl::expected<Recording, std::string> take_interface(Recording recording, std::string_view file_name,
                                                    std::string_view interface);

/// Decodes a whole log and prints heading, frames and summary; returns the exit status. Of several
/// protocols the one that finds the most snapshots reads it.
int decode_can_recording(const Recording& recording, std::span<const ProtocolUse> uses,
                         FramePrinter& printer, std::ostream& talk);

/// Where the lines of a log come from. `read` returns the next text, none at the end; `name` is
/// what messages call it.
struct CanLogSource {
    std::function<std::string()> read;
    std::string name;
    std::string interface;  ///< as for take_interface
};

/// Decodes a log as its lines come. Lines that cannot be used are reported and left out; returns
/// the exit status, 1 if there was any, or where a second interface shows up unasked.
int decode_can_stream(const CanLogSource& source, const ProtocolUse& use, FramePrinter& printer,
                      std::ostream& results, std::ostream& talk);

}  // namespace tribus
