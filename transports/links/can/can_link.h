#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/can_bus_state.h"
#include "core/can_frame.h"
#include "core/time.h"
#include "transports/links/link.h"

namespace tribus {

/// Most frames that one read takes from one interface: 7 ms of a 1 Mbit/s bus full of the shortest
/// frames are 149.
inline constexpr std::size_t kCanFramesPerRead = 64;

/// Limit of the senders on one interface: its outputs, and a node.
inline constexpr std::size_t kMostCanOutputs = 16;
inline constexpr std::size_t kMostLanes = kMostCanOutputs + 1;

/// Origin of a received frame.
enum class CanSender : std::uint8_t {
    bus,    ///< another node, or unknown
    local,  ///< another program on this machine
};

/// A received frame with its arrival.
struct ReceivedCanFrame {
    CanFrame frame;
    Instant at{};  ///< when the kernel received it; the earliest possible instant if the kernel
                   ///< does not say
    CanSender sender = CanSender::bus;
};

/// Result of one read.
struct CanReception {
    std::array<ReceivedCanFrame, kCanFramesPerRead> frames{};
    std::size_t count = 0;
    bool full = false;  ///< the read was full: more frames may be waiting

    std::span<const ReceivedCanFrame> view() const { return {frames.data(), count}; }
};

/// Counts of events on one interface since it was opened. They only ever increase.
struct CanCounts {
    std::uint64_t received = 0;
    std::uint64_t sent = 0;        ///< frames accepted by the kernel
    std::uint64_t confirmed = 0;   ///< frames that have left the controller
    std::uint64_t queue_full = 0;  ///< ENOBUFS; the frame is tried again later
    std::uint64_t abandoned = 0;   ///< snapshots of which a frame was never sent
    std::uint64_t stalls = 0;
    std::uint64_t bus_offs = 0;
    std::uint64_t downs = 0;
    std::uint64_t error_frames = 0;
    std::uint64_t missing_acknowledges = 0;  ///< error frames that report a missing acknowledgement
    std::uint64_t receive_overflows = 0;     ///< frames for which the socket had no room
    std::uint64_t implausible_times = 0;     ///< implausible time stamps of the kernel
};

struct CanLinkStatus {
    CanBusState state = CanBusState::ready;
    CanCounts counts;
};

/// One CAN interface, shared by all inputs and outputs that name it. At most one snapshot of each
/// lane is in progress, and its rest is abandoned when the bus stalls, so a bus that returns never
/// carries a burst of old values. Only the loss of the device ends the link. Thread-bound.
class CanLink : public Link {
  public:
    /// Reads the waiting frames, at most kCanFramesPerRead. Error frames and confirmations are
    /// processed and not returned. `wall_time` is the system clock at `now`, since 1970: the scale
    /// of the kernel's time stamps.
    virtual ReadStatus read(CanReception& reception, Instant now, Duration wall_time) = 0;

    /// Takes the frames of one snapshot of the sender `lane`, at most kMostSnapshotFrames. Busy
    /// while frames of the lane's previous snapshot are in progress.
    virtual WriteStatus write(std::size_t lane, std::span<const CanFrame> snapshot,
                              Instant now) = 0;

    /// Sends frames that are due and detects stalls. Returns when to call it again at the latest.
    virtual Instant poll(Instant now) = 0;

    virtual CanBusState state() const = 0;
    virtual CanLinkStatus status() const = 0;
    CanLink* as_can() final { return this; }
};

}  // namespace tribus
