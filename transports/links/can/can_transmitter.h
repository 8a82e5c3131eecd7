#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/can_frame.h"
#include "core/time.h"
#include "transports/links/can/can_link.h"
#include "transports/links/link.h"

namespace tribus {

/// Decides which snapshot of which sender goes to the kernel, and when. One snapshot is in flight
/// on the whole interface: the next one is handed over when the one before has left the controller.
/// A controller repeats a frame for ever if no node acknowledges it, and the kernel queues the
/// frames after it (docs/protocols/can.md, "SocketCAN: transmit queue"). This way one old snapshot
/// can wait there, but no more. On a bus that had errors or an outage the first frame goes alone
/// and the others when it is confirmed, so that only one frame can wait there. Where the driver
/// does not confirm, the others follow when the first has left the kernel's queue, which says less.
///
/// Pure: time is an argument, the caller executes `next` and reports the result. Thread-bound. No
/// heap.
class CanTransmitter {
  public:
    /// A frame that has not left by then is not acknowledged by any node, or the bus is full; a
    /// snapshot of that age is not worth sending. Radio links use 50 ms too (docs/protocols/can.md,
    /// "SocketCAN: transmit queue"). The longest wait of an urgent frame on a working bus is below
    /// 2 ms (docs/protocols/can.md, "Worst wait of a frame").
    static constexpr Duration kMostWait = std::chrono::milliseconds(50);
    /// Period of retries while the kernel's queue is full of other programs' frames: poll() does
    /// not tell when it has room (docs/protocols/can.md, "SocketCAN: transmit queue"). Ten frames
    /// at 1 Mbit/s.
    static constexpr Duration kFullRetry = std::chrono::milliseconds(1);
    /// Period of probe frames that test whether a bus-off is over, if nothing reports it. A driver
    /// that reports it removes the carrier, which the kernel shows up to a second later. Until then
    /// it accepts frames and drops them, so an earlier probe would seem to be sent.
    static constexpr Duration kProbePeriod = std::chrono::seconds(2);
    /// The kernel shows an interface as running shortly before it accepts frames, and loses frames
    /// of that time without an error.
    static constexpr Duration kSettlingTime = std::chrono::milliseconds(5);

    /// Error level of a controller that takes part in the traffic.
    enum class ErrorLevel : std::uint8_t { active, warning, passive };

    /// `counts` is borrowed; the transmitter increments the counts of sending. `confirms`: the
    /// driver confirms each frame that has left.
    CanTransmitter(CanCounts& counts, bool confirms) : counts_(counts), confirms_(confirms) {}

    /// Takes the snapshot of a lane, 1 to kMostSnapshotFrames frames. It replaces a snapshot of
    /// which no frame has been handed over; if one has, returns busy. Unavailable while the bus is
    /// stalled, in bus-off or down, except for a probe.
    WriteStatus offer(std::size_t lane, std::span<const CanFrame> snapshot, Instant now);

    /// The frames to hand to the kernel now, all of one snapshot, in this order; none if it is not
    /// the time. After some, call one of the four functions below. Valid until the next call of any
    /// other function.
    std::span<const CanFrame> next(Instant now);

    /// The kernel has accepted the first `count` of these frames, at least one.
    void handed(std::size_t count, Instant now);
    /// The kernel has no room.
    void refused_full(Instant now);
    /// The kernel will never accept the first of these frames. Abandons its snapshot.
    void refused();
    /// The interface is down. Nothing is in flight, since going down empties the queues.
    void went_down();

    /// The interface is up, with a carrier.
    void came_up(Instant now);
    /// This frame has left the controller. Without effect if it is not in flight.
    void confirmed(const CanFrame& frame, Instant now);
    /// All frames in flight have left the controller.
    void confirmed_all();
    /// The frames in flight, or their confirmations, are certainly lost.
    void forget_flight();
    void bus_off(Instant now);
    /// The controller restarted, with empty buffers.
    void restarted(Instant now);
    /// The controller did something that is impossible in bus-off, such as receiving a frame.
    void alive(Instant now);
    void error_level(ErrorLevel level);

    /// Detects frames and snapshots that have waited too long. `next` and `offer` do so too.
    void poll(Instant now);
    /// When to call `poll` or `next` again at the latest.
    Instant due() const;

    CanBusState state() const;
    bool in_flight() const { return in_flight_ != 0; }
    /// When the frames in flight were handed over, or the latest of them was confirmed.
    Instant in_flight_since() const { return flight_since_; }

  private:
    using Set = std::uint32_t;  ///< of lanes, or of frames of a snapshot; bit 0 is the first
    static_assert(kMostLanes <= 32 && kMostSnapshotFrames <= 32);

    struct Lane {
        std::array<CanFrame, kMostSnapshotFrames> frames{};
        std::size_t count = 0;
        std::size_t gone = 0;  ///< frames that were handed over
        Instant offered{};

        bool begun() const { return gone > 0; }
    };

    bool pending(std::size_t lane) const { return (pending_ >> lane & 1) != 0; }
    void abandon(std::size_t lane);
    void abandon_all();
    void end_turn();
    void bus_works();

    CanCounts& counts_;
    bool confirms_;
    std::array<Lane, kMostLanes> lanes_{};
    Set pending_ = 0;  ///< lanes with frames that were not handed over; none while down
    std::size_t serving_ = 0;
    std::array<CanFrame, kMostSnapshotFrames> flight_{};
    Set in_flight_ = 0;  ///< frames of `flight_` that were not confirmed
    Instant flight_since_{};
    bool careful_ = true;              ///< until a flight was confirmed without errors
    bool flight_may_be_gone_ = false;  ///< after a bus-off; it gets one more kMostWait
    Instant retry_at_{};
    Instant probe_at_{};
    ErrorLevel level_ = ErrorLevel::active;
    bool stalled_ = false;
    bool full_ = false;       ///< the latest answer of the kernel
    bool full_long_ = false;  ///< the queue was full until a snapshot was too old
    bool bus_off_ = false;
    bool down_ = false;
};

}  // namespace tribus
