#pragma once

#include <cstdint>
#include <functional>
#include <iosfwd>
#include <string>
#include <string_view>

#include <tl/expected.hpp>

#include "core/time.h"
#include "transports/links/recording.h"

/// Logs of candump for `decode`: one interface at a time, as a whole or as the lines come.
namespace tribus {

/// The frames of one interface of a log; `interface` empty: of the only one that it names. The
/// error, `file: text`, lists those that it names.
tl::expected<Recording, std::string> take_interface(Recording recording, std::string_view file_name,
                                                    std::string_view interface);

/// Where the lines of a log come from. `read` returns the next text, none at the end; `name` is
/// what messages call it.
struct CanLogSource {
    std::function<std::string()> read;
    std::string name;
    std::string interface;  ///< as for take_interface
};

/// What there is to say of a log at its end.
struct CanLogEnd {
    std::uint64_t error_frames = 0;
    Duration log_start{};
    /// A line could not be used, or the interface was not there, or a second one was, unasked.
    bool failed = false;
};

/// Calls `take` for every frame as its line comes, until the log ends or `results` take no more,
/// and flushes `results` behind each text that was read. Lines that cannot be used are reported to
/// `talk` and left out.
CanLogEnd read_can_log(const CanLogSource& source,
                       const std::function<void(const RecordedCanFrame&)>& take,
                       std::ostream& results, std::ostream& talk);

}  // namespace tribus
