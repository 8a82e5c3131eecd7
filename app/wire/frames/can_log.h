#pragma once

#include <cstdint>
#include <functional>
#include <iosfwd>
#include <span>
#include <string>
#include <string_view>

#include <tl/expected.hpp>

#include "core/time.h"
#include "transports/recordings/recording.h"

/// Candump logs for `decode`: one interface at a time, as a whole or while lines arrive.
namespace tribus {

/// Whether the frames of `interface` can be read from a log that has frames of `names`. If it is
/// empty, there must be only one. The error, `file: text`, lists the interfaces of the log.
tl::expected<void, std::string> check_interface(std::span<const std::string> names,
                                                std::string_view file_name,
                                                std::string_view interface);

/// Source of the lines of a log. `read` returns the next text, none at the end; `name` is its name
/// in messages.
struct CanLogSource {
    std::function<std::string()> read;
    std::string name;
    std::string interface;  ///< as in check_interface
};

/// Result of reading a log.
struct CanLogEnd {
    LogFacts log;
    /// A line could not be used, the interface was missing, or there was a second one that was not
    /// asked for.
    bool failed = false;
};

/// Calls `take` for each frame as its line arrives, until the log ends or `results` fails. Flushes
/// `results` after each text that was read. Reports unusable lines to `messages` and skips them.
CanLogEnd read_can_log(const CanLogSource& source,
                       const std::function<void(const RecordedCanFrame&)>& take,
                       std::ostream& results, std::ostream& messages);

}  // namespace tribus
