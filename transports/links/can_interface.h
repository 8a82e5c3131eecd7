#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <tl/expected.hpp>
#include <vector>

namespace tribus {

/// More queued frames than the snapshots of all outputs have would be old when they leave.
inline constexpr std::uint32_t kMostUsefulQueue = 64;

/// The controller's own view of its part in the traffic; the kernel's enum can_state.
enum class CanControllerState : std::uint8_t {
    active,
    warning,
    passive,
    bus_off,
    stopped,
    sleeping
};

/// A network interface as the kernel describes it (rtnetlink). What its driver does not tell is
/// absent: virtual interfaces have neither bit rate nor controller.
struct CanInterface {
    std::string name;
    std::string kind;  ///< "can" (a controller), "vcan", "vxcan"; may be empty
    std::uint32_t index = 0;
    bool is_can = false;
    bool up = false;
    bool lower_up = false;  ///< has a carrier
    /// Own frames come back when they have left the controller, not before.
    bool echo = false;
    std::uint32_t mtu = 0;
    std::uint32_t queue_length = 0;                      ///< frames; 0 is no queue
    std::optional<std::uint32_t> bit_rate;               ///< bit/s
    std::optional<std::uint32_t> data_bit_rate;          ///< bit/s, in the fast part of FD frames
    std::optional<std::uint32_t> sample_point_permille;  ///< of the bit
    std::optional<std::uint32_t> restart_ms;             ///< 0: never by itself
    std::optional<CanControllerState> state;
    std::optional<std::uint16_t> transmit_errors;  ///< the controller's error counters
    std::optional<std::uint16_t> receive_errors;
    bool loopback = false;
    bool listen_only = false;
    bool one_shot = false;
    bool fd = false;  ///< the controller's FD mode is on
    bool bus_error_reporting = false;

    bool takes_fd() const;
};

/// What one RTM_NEWLINK message says; nothing if it is none or is damaged. Pure.
std::optional<CanInterface> parse_link_message(std::span<const std::byte> message);

/// Why it does not take FD frames and what to do; nothing if it does. Pure.
std::optional<std::string> fd_problem(const CanInterface& interface);

/// What of the interface makes RC over it worse, each as a sentence with the command that changes
/// it. Pure.
std::vector<std::string> advice(const CanInterface& interface, bool sends, bool fd_wanted);

/// One line for the log at start-up. Pure.
std::string summary(const CanInterface& interface);

/// Asks the kernel. The error says what is wrong with the name and which CAN interfaces there are.
/// May block: not for the data path.
tl::expected<CanInterface, std::string> query_can_interface(const std::string& name);

/// Ends a bus-off, as `ip link set can0 type can restart`: needs CAP_NET_ADMIN. May block.
tl::expected<void, std::string> restart_can_interface(const std::string& name);

}  // namespace tribus
