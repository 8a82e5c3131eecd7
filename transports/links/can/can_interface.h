#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <tl/expected.hpp>
#include <vector>

namespace tribus {

/// The snapshots of all outputs need no more. Frames in a longer queue would be old when they are
/// sent.
inline constexpr std::uint32_t kMostUsefulQueue = 64;

/// Error state of the controller, as in the kernel's enum can_state.
enum class CanControllerState : std::uint8_t {
    active,
    warning,
    passive,
    bus_off,
    stopped,
    sleeping
};

/// A network interface as described by the kernel (rtnetlink). Values that its driver does not
/// report are absent: virtual interfaces have neither bit rate nor controller.
struct CanInterface {
    std::string name;
    std::string kind;  ///< "can" (a controller), "vcan", "vxcan"; may be empty
    std::uint32_t index = 0;
    bool is_can = false;
    bool up = false;
    bool lower_up = false;  ///< has a carrier
    bool running = false;   ///< the kernel has taken note of the carrier
    /// Own frames come back when they have left the controller, not before.
    bool echo = false;
    std::uint32_t mtu = 0;
    std::uint32_t queue_length = 0;                      ///< frames; 0: no queue
    std::optional<std::uint32_t> bit_rate;               ///< bit/s
    std::optional<std::uint32_t> data_bit_rate;          ///< bit/s, in the fast part of FD frames
    std::optional<std::uint32_t> sample_point_permille;  ///< position in the bit
    std::optional<std::uint32_t> restart_ms;             ///< 0: no automatic restart
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

/// Reads an RTM_NEWLINK message. Returns nothing for another or a damaged message. Pure and
/// reentrant.
std::optional<CanInterface> parse_link_message(std::span<const std::byte> message);

/// Why the interface cannot send FD frames, and what to do; nothing if it can. Pure and reentrant.
std::optional<std::string> fd_problem(const CanInterface& interface);

/// Settings of the interface that are bad for RC, each as a sentence with the command that changes
/// it. Pure and reentrant.
std::vector<std::string> advice(const CanInterface& interface, bool sends, bool fd_wanted);

/// One line for the log at the start. Pure and reentrant.
std::string summary(const CanInterface& interface);

/// Whether no network interface has that name although it is valid: it may be plugged in later.
/// Loads no module for it, as an ioctl with a name may. May block: not for the data path.
bool is_can_interface_missing(const std::string& name);

/// Reads the interface from the kernel. The error says what is wrong with the name and lists the
/// CAN interfaces. May block: not for the data path.
tl::expected<CanInterface, std::string> query_can_interface(const std::string& name);

/// Ends a bus-off like `ip link set can0 type can restart`. Needs CAP_NET_ADMIN. May block.
tl::expected<void, std::string> restart_can_interface(const std::string& name);

}  // namespace tribus
