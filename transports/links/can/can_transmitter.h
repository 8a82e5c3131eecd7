#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "core/can_frame.h"
#include "core/time.h"
#include "transports/links/can/can_link.h"
#include "transports/links/link.h"

namespace tribus {

/// Decides which frame of which sender goes to the kernel, and when. One frame is in flight on the
/// whole interface: the next one is handed over when the one before has left the controller. A
/// controller repeats a frame for ever if no node acknowledges it, and the kernel queues the frames
/// after it (docs/protocols/can.md, "SocketCAN: transmit queue"). This way one old frame can wait
/// there, but never a burst.
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

    /// `counts` is borrowed; the transmitter increments the counts of sending.
    explicit CanTransmitter(CanCounts& counts) : counts_(counts) {}

    /// Takes the snapshot of a lane, 1 to kMostSnapshotFrames frames. It replaces a snapshot of
    /// which no frame has been handed over; if one has, returns busy. Unavailable while the bus is
    /// stalled, in bus-off or down, except for a probe.
    WriteStatus offer(std::size_t lane, std::span<const CanFrame> snapshot, Instant now);

    /// The frame to hand to the kernel now, or null. After a frame, call one of the four functions
    /// below. Valid until the next call of any other function.
    const CanFrame* next(Instant now);

    void handed(Instant now);
    /// The kernel has no room.
    void refused_full(Instant now);
    /// The kernel will never accept the frame. Abandons its snapshot.
    void refused();
    /// The interface is down. Nothing is in flight, since going down empties the queues.
    void went_down();

    /// The interface is up, with a carrier.
    void came_up(Instant now);
    /// The frame in flight has left the controller.
    void confirmed();
    /// The frame in flight, or its confirmation, is certainly lost.
    void forget_flight();
    void bus_off(Instant now);
    /// The controller restarted, with empty buffers.
    void restarted(Instant now);
    /// The controller did something that is impossible in bus-off, such as receiving a frame.
    void alive(Instant now);
    void error_level(ErrorLevel level) { level_ = level; }

    /// Detects frames that have waited too long. `next` and `offer` do so too.
    void poll(Instant now);
    /// When to call `poll` or `next` again at the latest.
    Instant due() const;

    CanBusState state() const;
    /// The frame in flight, or null.
    const CanFrame* in_flight() const { return in_flight_ ? &*in_flight_ : nullptr; }
    Instant in_flight_since() const { return flight_since_; }

  private:
    struct Lane {
        std::array<CanFrame, kMostSnapshotFrames> frames{};
        std::size_t count = 0;
        std::size_t gone = 0;  ///< frames that were handed over
        Instant offered{};

        bool pending() const { return gone < count; }
        bool begun() const { return gone > 0; }
    };

    void abandon(Lane& lane);
    void abandon_all();
    void end_turn();
    bool anything_pending() const;

    CanCounts& counts_;
    std::array<Lane, kMostLanes> lanes_{};
    std::size_t serving_ = 0;
    std::optional<CanFrame> in_flight_;
    Instant flight_since_{};
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
