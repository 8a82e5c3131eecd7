#pragma once

#include <optional>
#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>
#include <tl/expected.hpp>

#include "core/time.h"

/// Commands that talk with a running daemon of this machine. Errors are for the person who asked.
namespace tribus {

/// Its control socket: `socket` where one is given; else that of the daemon called `name`, which
/// may be its configuration file too; or, where the name is empty, of the only one that runs.
tl::expected<std::string, std::string> find_daemon(const std::string& name,
                                                   const std::optional<std::string>& socket);

/// One request, a line of words, and its answer, for which it waits so long at most. An answer that
/// tells of an error is one.
tl::expected<nlohmann::json, std::string> ask_daemon(const std::string& socket,
                                                     std::string_view request, Duration patience);

}  // namespace tribus
