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

/// The frame as a raw CAN socket takes it, and how many bytes of it: CAN_MTU or CANFD_MTU.
struct WireCanFrame {
    canfd_frame frame{};
    std::size_t size = CAN_MTU;
};

WireCanFrame to_wire(const CanFrame& frame);

/// What a raw CAN socket read, if it is a data or remote frame: `size` tells classic from FD
/// frames, whose length is limited to what the frame holds. Nothing for error frames and sizes
/// that are no frame.
std::optional<CanFrame> from_wire(const canfd_frame& wire, std::size_t size);

/// Same id and content. The flags that say how an FD frame travelled are the drivers' business.
bool same_message(const CanFrame& a, const CanFrame& b);

/// What an error frame of the kernel says (linux/can/error.h).
struct CanErrorReport {
    bool transmit_timeout = false;
    bool no_acknowledge = false;
    bool bus_off = false;
    bool restarted = false;
    bool active = false;   ///< recovered to few errors
    bool warning = false;  ///< many errors, receiving or sending
    bool passive = false;
    bool receive_overflow = false;   ///< of the controller
    bool transmit_overflow = false;  ///< of the controller

    bool operator==(const CanErrorReport&) const = default;
};

/// Nothing if it is no error frame.
std::optional<CanErrorReport> error_report(const canfd_frame& wire);

/// The error classes to ask for. Bus errors in single frames are left out: they can flood.
extern const can_err_mask_t kWantedErrors;

/// Most filters of one socket; 513 are refused (docs/protocols/can.md, "SocketCAN: sockets").
inline constexpr std::size_t kMostCanFilters = 512;

/// Kernel filters for data frames of these ids, each once; who wants all ids gets remote frames
/// too. The bits for extended and remote frames are in every other mask: without them 0x123 also
/// passes 29-bit ids that end so (docs/protocols/can.md, "SocketCAN: sockets").
std::vector<can_filter> kernel_filters(std::span<const CanIdMatch> wanted);

/// When a frame arrived, on our time line.
struct Arrival {
    Instant at{};
    bool believed = true;  ///< the kernel's stamp was plausible, or there was none

    bool operator==(const Arrival&) const = default;
};

/// A frame with an older stamp has a wrong stamp (docs/protocols/can.md, "SocketCAN: time stamps"),
/// unless reading was held up.
inline constexpr Duration kMostPlausibleAge = std::chrono::milliseconds(100);

/// `stamp` is the kernel's time of arrival, since 1970; `wall_time` that of the instant `now`. The
/// frame came after `oldest`, when nothing waited. Ages from 0 to that, or kMostPlausibleAge, are
/// believed; with another stamp, or none, it may have come at `oldest`. A stamp up to
/// kMostPlausibleAge later than `now` is no fault: the frame came while the caller was at work.
Arrival plausible_arrival(std::optional<Duration> stamp, Duration wall_time, Instant now,
                          Instant oldest);

}  // namespace tribus
