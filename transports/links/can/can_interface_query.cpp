#include <cerrno>
#include <utility>

#include "transports/links/can/can_netlink.h"
#include "transports/links/unique_fd.h"

namespace tribus {

namespace {

/// Returns the interfaces in the answer, or an errno.
tl::expected<std::vector<CanInterface>, int> ask(const NetlinkRequest& request) {
    const UniqueFd fd = open_netlink();
    if (!fd.valid()) {
        return tl::unexpected(errno);
    }
    return ask_by(fd.get(), request);
}

std::string those_that_there_are() {
    return existing_can_interfaces(
        ask(request_of_all_interfaces()).value_or(std::vector<CanInterface>{}));
}

}  // namespace

bool is_can_interface_missing(const std::string& name) {
    if (!is_name_of_interface(name)) {
        return false;
    }
    const auto found = ask(request_of_interface(name));
    return !found && found.error() == ENODEV;
}

tl::expected<CanInterface, std::string> query_can_interface(const std::string& name) {
    const auto failed = [&name](const std::string& why) {
        return tl::unexpected(name + ": " + why);
    };
    if (!is_name_of_interface(name)) {
        return failed("names of network interfaces have 1 to 15 characters, such as can0");
    }
    const auto found = ask(request_of_interface(name));
    if (!found && found.error() != ENODEV) {
        return failed(asking_problem(found.error()));
    }
    if (!found || found->empty()) {
        return failed("there is no such network interface; " + those_that_there_are());
    }
    const CanInterface& interface = found->front();
    if (!interface.is_can) {
        return failed("this network interface is not a CAN interface; " + those_that_there_are());
    }
    return interface;
}

tl::expected<void, std::string> restart_can_interface(const std::string& name) {
    if (const auto answer = ask(request_of_restart(name)); !answer) {
        return tl::unexpected(restart_problem(name, answer.error()));
    }
    return {};
}

}  // namespace tribus
