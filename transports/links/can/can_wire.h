#pragma once

#include <linux/can.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/can_frame.h"
#include "core/time.h"

namespace tribus {

/// Converts a frame to the form of a raw CAN socket. Limits its length to what its kind allows.
/// Returns the size of the result, CAN_MTU or CANFD_MTU; bytes of `wire` beyond it are not written.
std::size_t to_wire(const CanFrame& frame, canfd_frame& wire);

/// Converts a data or remote frame from a raw CAN socket. `size` distinguishes classic from FD
/// frames, whose length is limited to that of the frame. Returns nothing for error frames and sizes
/// of no frame.
std::optional<CanFrame> from_wire(const canfd_frame& wire, std::size_t size);

/// Same id and content. The transmission flags of FD frames may differ, since drivers set them.
bool same_message(const CanFrame& a, const CanFrame& b);

/// Content of an error frame of the kernel (linux/can/error.h).
struct CanErrorReport {
    bool transmit_timeout = false;
    bool no_acknowledge = false;
    bool bus_off = false;
    bool restarted = false;
    bool active = false;   ///< back to few errors
    bool warning = false;  ///< many errors, receiving or sending
    bool passive = false;
    bool receive_overflow = false;   ///< in the controller
    bool transmit_overflow = false;  ///< in the controller

    bool operator==(const CanErrorReport&) const = default;
};

/// Returns nothing if the frame is no error frame.
std::optional<CanErrorReport> error_report(const canfd_frame& wire);

/// The error classes to request. Without single bus errors, which can flood.
extern const can_err_mask_t kWantedErrors;

/// Most filters of one socket; the kernel refuses 513 (docs/protocols/can.md, "SocketCAN:
/// sockets").
inline constexpr std::size_t kMostCanFilters = 512;

/// Kernel filters for data frames of these ids, without repetitions. A filter for all ids also
/// passes remote frames. All others have the bits for extended and remote frames in their mask:
/// without them, 0x123 also passes 29-bit ids with this end (docs/protocols/can.md, "SocketCAN:
/// sockets").
std::vector<can_filter> kernel_filters(std::span<const CanIdMatch> wanted);

/// Arrival of a frame on the monotonic time line.
struct Arrival {
    Instant at{};
    bool plausible = true;  ///< the kernel's stamp was plausible, or there was none

    bool operator==(const Arrival&) const = default;
};

/// Limit of a plausible age (docs/protocols/can.md, "SocketCAN: time stamps"), unless reading was
/// delayed.
inline constexpr Duration kMostPlausibleAge = std::chrono::milliseconds(100);

/// `stamp` is the kernel's time of arrival, `wall_time` the system clock at `now`, both since 1970.
/// The frame arrived after `oldest`, when no frame was waiting. Accepts ages from 0 to that, or to
/// kMostPlausibleAge. With another stamp, or none, the arrival is `oldest`. A stamp up to
/// kMostPlausibleAge after `now` is valid: the frame arrived while the caller was working.
Arrival plausible_arrival(std::optional<Duration> stamp, Duration wall_time, Instant now,
                          Instant oldest);

}  // namespace tribus
