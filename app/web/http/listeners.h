#pragma once

#include <optional>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "app/client/control_socket.h"
#include "transports/links/unique_fd.h"

/// The places at which the page is served.
namespace tribus::web {

/// A listening socket that does not block.
struct Listener {
    UniqueFd socket;
    /// Removes the file of a local socket that this program made.
    std::optional<LocalListener> file;
};

/// Sockets that systemd listens on for this program (sd_listen_fds(3)); empty without it. One that
/// the network can reach is refused unless `is_public`. Errors are sentences.
tl::expected<std::vector<Listener>, std::string> inherited_listeners(bool is_public);
/// Listens at 127.0.0.1:PORT, [::1]:PORT, the path of a local socket, or another address if the
/// network may reach it.
tl::expected<Listener, std::string> listen_at(const std::string& address, bool is_public);

/// The address of a listener: `http://127.0.0.1:8480/`, or the path of its local socket.
std::string place_of(const Listener& listener);

}  // namespace tribus::web
