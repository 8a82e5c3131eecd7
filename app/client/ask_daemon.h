#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>
#include <tl/expected.hpp>

#include "app/cli/command.h"
#include "core/time.h"

/// Requests of commands to a running daemon on this machine. Errors are written for the user.
namespace tribus {

/// Names of the daemons that run and that this user may ask, for completion.
std::vector<std::string> running_daemons();

/// Options of a command that asks a daemon, for find_daemon().
CommandOption daemon_name_option(std::string& name);
CommandOption daemon_socket_option(std::optional<std::string>& socket);

/// Purpose for which a command looks for a daemon.
enum class Wants : std::uint8_t {
    change,
    look,  ///< the socket that only tells is enough
};

/// Path of the control socket: `socket` if given; else that of the daemon `name`, which may also be
/// its configuration file; if `name` is empty, that of the only daemon that runs. Who
/// may only look gets the socket that only tells.
tl::expected<std::string, std::string> find_daemon(const std::string& name,
                                                   const std::optional<std::string>& socket,
                                                   Wants wants = Wants::change);

/// Sends one request and returns its answer; waits for at most `patience`. An answer of type
/// "error" becomes the error.
tl::expected<nlohmann::json, std::string> ask_daemon(const std::string& socket,
                                                     std::string_view request, Duration patience);

}  // namespace tribus
