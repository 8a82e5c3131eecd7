#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "transports/links/can/can_interface.h"
#include "transports/links/unique_fd.h"

/// Questions to the kernel about network interfaces (rtnetlink), and its answers. Errors are values
/// of errno. All but `open_netlink` and `ask_by` are pure; any thread may call them.
namespace tribus {

/// A request of rtnetlink, as it is sent.
using NetlinkRequest = std::vector<std::byte>;

NetlinkRequest request_of_interface(const std::string& name);
NetlinkRequest request_of_all_interfaces();
/// Restarts a controller, which ends its bus-off.
NetlinkRequest request_of_restart(const std::string& name);

/// Whether a network interface can have this name.
bool is_name_of_interface(const std::string& name);

/// Reads the messages in one datagram of an answer. Returns whether more will follow, or the
/// kernel's error.
tl::expected<bool, int> take_messages(std::span<const std::byte> datagram,
                                      std::vector<CanInterface>& found);

/// Opens a socket for `ask_by`, which waits 5 s for an answer. Invalid, with errno, if that fails.
UniqueFd open_netlink();

/// Sends a request and reads the whole answer. Blocks as the socket does.
tl::expected<std::vector<CanInterface>, int> ask_by(int socket, const NetlinkRequest& request);

/// Names those of them that are CAN interfaces, or says how to get one.
std::string existing_can_interfaces(std::span<const CanInterface> all);
/// Why the kernel did not answer.
std::string asking_problem(int error);
/// Why the controller was not restarted, and what to do.
std::string restart_problem(const std::string& name, int error);

}  // namespace tribus
