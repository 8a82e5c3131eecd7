#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/can_frame.h"
#include "core/time.h"
#include "transports/links/link.h"

namespace tribus {

/// Most frames that one read takes from one interface: 7 ms of a 1 Mbit/s bus full of the shortest
/// frames are 149.
inline constexpr std::size_t kCanFramesPerRead = 64;

/// Senders that one interface serves: its outputs, and a node.
inline constexpr std::size_t kMostCanOutputs = 16;
inline constexpr std::size_t kMostLanes = kMostCanOutputs + 1;

enum class CanSender : std::uint8_t {
    bus,    ///< another node, or nobody can tell
    local,  ///< another program on this machine
};

struct ReceivedCanFrame {
    CanFrame frame;
    Instant at{};  ///< when the kernel took it; the earliest possible if it does not tell that
    CanSender sender = CanSender::bus;
};

struct CanReception {
    std::array<ReceivedCanFrame, kCanFramesPerRead> frames{};
    std::size_t count = 0;
    bool full = false;  ///< it took as much as one read takes: more may wait

    std::span<const ReceivedCanFrame> view() const { return {frames.data(), count}; }
};

/// What an interface can do for a sender now.
enum class CanBusState : std::uint8_t {
    ready,
    warning,  ///< the controller counts many errors
    passive,  ///< more: it can still send, if anybody listens
    stalled,  ///< a frame has not left for too long: nobody acknowledges, or the bus is full
    bus_off,  ///< the controller has withdrawn from the bus
    down,     ///< the interface is down
};

/// Events of one interface since it was opened. Only ever incremented.
struct CanCounts {
    std::uint64_t received = 0;
    std::uint64_t sent = 0;        ///< frames taken by the kernel
    std::uint64_t confirmed = 0;   ///< frames that have left the controller
    std::uint64_t queue_full = 0;  ///< ENOBUFS: tried again later
    std::uint64_t abandoned = 0;   ///< snapshots of which a part was never sent
    std::uint64_t stalls = 0;
    std::uint64_t bus_offs = 0;
    std::uint64_t downs = 0;
    std::uint64_t error_frames = 0;
    std::uint64_t missing_acknowledges = 0;  ///< error frames that say so
    std::uint64_t receive_overflows = 0;     ///< frames that the socket had no room for
    std::uint64_t implausible_times = 0;     ///< kernel times that were not believed
};

struct CanLinkStatus {
    CanBusState state = CanBusState::ready;
    CanCounts counts;
};

/// One CAN interface, shared by all inputs and outputs that name it. At most one snapshot of a
/// lane is under way and the rest of it is abandoned when the bus stalls, so a bus that comes back
/// never carries old values in a burst. Nothing ends it but the loss of the device.
class CanLink : public Link {
  public:
    /// Reads what is there, at most kCanFramesPerRead. Error frames and confirmations are
    /// digested and not among the received ones. `wall_time` is the time of the system clock at
    /// `now`, since 1970: the kernel's stamps are on that scale.
    virtual ReadStatus read(CanReception& reception, Instant now, Duration wall_time) = 0;

    /// Takes the frames of one snapshot of the sender `lane`, at most kMostSnapshotFrames. Busy
    /// while frames of the lane's snapshot before are under way.
    virtual WriteStatus write(std::size_t lane, std::span<const CanFrame> snapshot,
                              Instant now) = 0;

    /// Sends what can go, and watches for stalls. Returns when to call again at the latest.
    virtual Instant poll(Instant now) = 0;

    virtual CanLinkStatus status() const = 0;
    CanLink* as_can() final { return this; }
};

}  // namespace tribus
