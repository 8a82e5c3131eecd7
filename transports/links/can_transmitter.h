#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "core/can_frame.h"
#include "core/time.h"
#include "transports/links/can_link.h"
#include "transports/links/link.h"

namespace tribus {

/// Decides which frame of which sender goes to the kernel, and when. One frame is in flight on the
/// whole interface: the next one is handed over when the one before has left the controller. A
/// controller whose frames nobody acknowledges repeats them for ever and the kernel queues what
/// follows (docs/protocols/can.md, "SocketCAN: transmit queue"); this way one old frame can be
/// caught there, never a burst.
///
/// Pure: time is an argument, the caller does what `next` says and reports what came of it.
/// Thread-bound. No heap.
class CanTransmitter {
  public:
    /// A frame that has not left after so long has no listener or a bus that is full; a snapshot
    /// that old is not worth sending. Radio links take 50 ms for the same (docs/protocols/can.md,
    /// "SocketCAN: transmit queue"); the worst wait of an urgent frame on a bus that works is below
    /// 2 ms (docs/protocols/can.md, "Worst wait of a frame").
    static constexpr Duration kMostWait = std::chrono::milliseconds(50);
    /// The kernel's queue is full of other programs' frames: poll() would not tell when it has room
    /// again (docs/protocols/can.md, "SocketCAN: transmit queue"). Ten frames of 1 Mbit/s.
    static constexpr Duration kFullRetry = std::chrono::milliseconds(1);
    /// How often a frame may try whether a bus-off is over, where nothing says so. A driver that
    /// says so takes the carrier away, which the kernel shows up to a second later; until then it
    /// takes frames and drops them, so that a probe would seem to have gone.
    static constexpr Duration kProbePeriod = std::chrono::seconds(2);
    /// The kernel shows an interface as running a moment before it takes frames, and loses those
    /// of that moment without a word.
    static constexpr Duration kSettlingTime = std::chrono::milliseconds(5);

    /// How the controller rates its errors, as long as it takes part in the traffic.
    enum class ErrorLevel : std::uint8_t { active, warning, passive };

    /// `counts` is borrowed; the transmitter counts there what concerns sending.
    explicit CanTransmitter(CanCounts& counts) : counts_(counts) {}

    /// Takes the snapshot of a lane, 1 to kMostSnapshotFrames frames. It replaces one of which no
    /// frame has gone yet; busy if that one has begun. Unavailable while the bus is stalled, off
    /// or down, but for a probe.
    WriteStatus offer(std::size_t lane, std::span<const CanFrame> snapshot, Instant now);

    /// The frame to hand to the kernel now, if there is one; then call one of the four below.
    /// Valid until the next call of any other function.
    const CanFrame* next(Instant now);

    void handed(Instant now);
    /// The kernel has no room.
    void refused_full(Instant now);
    /// The kernel will never take that frame: its snapshot is abandoned.
    void refused();
    /// The interface is down: nothing is in flight any more, since going down empties the queues.
    void went_down();

    /// The interface is up, with a carrier.
    void came_up(Instant now);
    /// The frame in flight has left the controller.
    void confirmed();
    /// The frame in flight, or its confirmation, is gone for certain.
    void forget_flight();
    void bus_off(Instant now);
    /// The controller started again, with empty buffers.
    void restarted(Instant now);
    /// Something that no controller in bus-off can do, such as receiving a frame.
    void alive(Instant now);
    void error_level(ErrorLevel level) { level_ = level; }

    /// Notices what has waited too long. `next` and `offer` do so, too.
    void poll(Instant now);
    /// When to call `poll` or `next` again at the latest.
    Instant due() const;

    CanBusState state() const;
    /// The frame in flight, null if there is none.
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
    bool flight_may_be_gone_ = false;  ///< a bus-off came between; it gets one more kMostWait
    Instant retry_at_{};
    Instant probe_at_{};
    ErrorLevel level_ = ErrorLevel::active;
    bool stalled_ = false;
    bool full_ = false;       ///< the kernel's latest answer
    bool full_long_ = false;  ///< until a snapshot was too old
    bool bus_off_ = false;
    bool down_ = false;
};

}  // namespace tribus
