#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "core/channel_frame.h"
#include "core/time.h"
#include "pipelines/carry_over.h"
#include "pipelines/engine.h"
#include "pipelines/line_words.h"
#include "pipelines/read_pacer.h"
#include "pipelines/realtime/capture_ring.h"
#include "pipelines/realtime/line_exchange.h"
#include "pipelines/realtime/machine_numbers.h"
#include "pipelines/realtime/snapshot.h"
#include "pipelines/realtime/timing.h"
#include "pipelines/value_engine.h"
#include "transports/links/can_link.h"
#include "transports/links/link.h"
#include "transports/links/unique_fd.h"

namespace tribus {

/// How one port is joined to the engine. One serial device may serve an input and an output, one
/// CAN interface many of each.
struct PortWiring {
    std::vector<std::size_t> inputs;
    std::vector<std::size_t> outputs;
    /// Of the engine of values.
    std::vector<std::size_t> sensor_buses{};
    std::vector<std::size_t> value_messages{};
    /// Of the engine: the node of DroneCAN on this interface.
    std::optional<std::size_t> node{};
    /// Of one byte on its wire; zero where that is not known or has no meaning.
    Duration byte_time{};
    /// Takes all that passes, with the very instants that the engine is told, which no wrapper of
    /// the link could know; null: nothing is recorded. Must outlive the loop.
    CaptureRing* capture = nullptr;
};

/// How a port of a new loop goes on from the one before.
struct PortCarry {
    /// Of the loop before: the same device or interface.
    CarriedFrom from{};
    /// It takes the open link with all that waits in it. Else it has its own, or will be given one.
    bool takes_link = false;
    /// Nobody read there until now: what waits in the link is old.
    bool discards_unread = false;
};

/// How a loop goes on from the one before.
struct LoopCarry {
    EngineCarry engine;
    ValueCarry values;
    std::vector<PortCarry> ports;
};

struct LoopSettings {
    /// So long before a deadline the thread stays awake for it, instead of being woken at it.
    Duration spin{};
    /// Where GPIO lines are configured; must outlive the loop.
    LineExchange* lines = nullptr;
    /// Where sensor buses or values are configured; must outlive the loop.
    ValueEngine* values = nullptr;
    /// What the machine tells of itself, by the main thread; must outlive the loop.
    const MachineNumbers* machine = nullptr;
};

/// No decoder refuses for more causes.
inline constexpr std::size_t kMostRejectCauses = 12;

/// What the main thread may know of an input.
struct InputStatus {
    /// As of when the data thread wrote this down.
    Instant at{};
    ChannelFrame latest;
    /// When the newest frame of all came, which may be behind `at`.
    Instant newest_at{};
    InputCounts counts;
    std::uint64_t rejected = 0;
    /// By cause, in the order in which its decoder names them.
    std::array<std::uint64_t, kMostRejectCauses> rejected_by{};
    std::uint64_t skipped_bytes = 0;
    Duration interval{};
    LinkState state;
    bool ever_good = false;
    bool two_senders = false;  ///< of its ids, mixed in what it reads
};

/// What the main thread may know of an output.
struct OutputStatus {
    /// As of when the data thread wrote this down.
    Instant at{};
    ChannelFrame latest;
    OutputCounts counts;
    std::uint64_t overruns = 0;
    OutputState state;
    /// Its next turn, and how long it is from one to the next.
    Instant due{};
    Duration period{};
    /// Its latest turn made a frame; a silent one makes none.
    bool speaks = false;
};

/// How often the data thread was away for longer than a receiver is usually given: stopped, starved
/// of processor time, or suspended with the machine.
struct AbsenceStatus {
    std::uint64_t count = 0;
    Duration latest{};
};

/// What the main thread may know of a named value.
struct ValueStatus {
    double number = 0;
    Instant at{};            ///< of the number
    bool ever = false;       ///< it had one
    bool available = false;  ///< its source has one now, stale or not
};

/// Drives an engine in real time: waits for bytes and deadlines, reads all that is ready, lets the
/// engine run, and writes what is due. It reads the clock at each wake, before and behind writes,
/// which tells the latency, and before it sleeps, so that it does not sleep longer. A wake that
/// comes late finds old bytes on all ports: they are read to the last one, as old as they may be,
/// before anything is written. One thread, the data thread, calls `run` and owns every link that is
/// in use; it never waits for another thread and does not allocate. The rest is for the main
/// thread, as each function says.
class Loop {
  public:
    /// Wants a link for each wiring; none where the device is missing and will be given.
    Loop(Engine& engine, std::vector<PortWiring> wiring, std::vector<std::unique_ptr<Link>> links,
         LoopSettings settings = {});
    Loop(const Loop&) = delete;
    Loop& operator=(const Loop&) = delete;
    ~Loop();

    /// Sets up what the loop waits on. Main thread, before `run`. The error is a sentence.
    tl::expected<void, std::string> prepare();

    /// Data thread. Returns nothing after `request_end`, when every output has said its last
    /// frames, or the loop that goes on in its place, after `hand_over_to`.
    Loop* run();

    /// These parts say their last frames from now on, as at the end; the others go on. Once, before
    /// `hand_over_to`. Main thread.
    void retire(Leaving leaving);
    /// They have said them. Thread-safe.
    bool retired() const { return retired_.load(std::memory_order_acquire); }
    /// Throws away what waits in the links of a loop that has not run yet: it is for the loop that
    /// still runs. Main thread.
    void discard_unread();
    /// `next`, which is prepared and has never run, goes on in the place of this loop, between two
    /// frames. Once `run` has returned it, this loop is of no use any more; links that `next` did
    /// not take are still in it. Main thread; both must live until then.
    void hand_over_to(Loop& next, LoopCarry carry);

    /// Thread-safe.
    void request_end();

    /// The link of `port` that the data thread has given up because its device is gone, if it has
    /// not been taken yet. Main thread.
    std::unique_ptr<Link> take_lost(std::size_t port);
    /// A fresh link for a port whose lost one was taken. Main thread.
    void give(std::size_t port, std::unique_ptr<Link> link);

    /// Thread-safe.
    InputStatus input_status(std::size_t input) const;
    OutputStatus output_status(std::size_t output) const { return output_status_[output].read(); }
    const InputTiming& input_timing(std::size_t input) const { return *input_timing_[input]; }
    const OutputTiming& output_timing(std::size_t output) const { return *output_timing_[output]; }
    SensorBusState bus_state(std::size_t bus) const { return bus_states_[bus].read(); }
    /// When the data thread last wrote down all of this: one that hangs does not any more.
    Instant published_at() const {
        return Instant(Duration(published_at_ns_.load(std::memory_order_acquire)));
    }
    AbsenceStatus absence() const { return absence_status_.read(); }
    /// By the places on the board.
    std::size_t value_count() const { return value_status_.size(); }
    ValueStatus value_status(std::size_t value) const { return value_status_[value].read(); }
    dronecan::NodeReport node_report(std::size_t node) const { return node_reports_[node].read(); }
    /// Of a port that is a CAN interface.
    CanLinkStatus can_status(std::size_t port) const { return ports_[port].can_status.read(); }

  private:
    struct Port {
        PortWiring wiring;
        std::unique_ptr<Link> link;
        /// Its own number, where the kernel points to when the link is ready; goes with the link.
        std::unique_ptr<std::size_t> place;
        std::atomic<Link*> lost{nullptr};
        std::atomic<Link*> given{nullptr};
        Snapshot<CanLinkStatus> can_status;
        ReadPacer pacer{Duration::zero()};
        /// Not watched until then; `kNever`: it is watched.
        Instant quiet_until = kNever;
    };
    /// Where the frames of an output go.
    struct Route {
        std::size_t port = 0;
        std::size_t lane = 0;
    };

    void begin();
    static void ring(int bell);
    Loop* successor(Instant now);
    void take_over(Loop& before, Instant now);
    void take_ports(Loop& before, Instant now);
    void take_link(std::size_t port, Port& before, const PortCarry& carry, Instant now);
    void read_second_sockets(Loop& before, Instant now);
    void take_waiting(Loop& before);
    static bool wants_bytes(const PortWiring& wiring);
    void discard_unread_of(Link& link, Instant now);
    void watch(std::size_t port);
    void set_watched(std::size_t port, bool watched);
    void lose(Port& port);
    void tell_outputs(const Port& port, bool present);
    void tell_outputs_of_links();
    void accept_given_links();
    void read_port(std::size_t port, Instant now);
    void read_quiet_ports(Instant now);
    ReadStatus read_bytes(std::size_t port, ByteLink& link, Instant now);
    ReadStatus read_can(const PortWiring& wiring, CanLink& link, Instant now);
    bool hand_on_bytes(const PortWiring& wiring, Instant at);
    void hand_on_can(const PortWiring& wiring);
    void end_quiet(Port& port);
    void catch_up(Instant since, Instant now);
    ReadStatus catch_up_on_bytes(const PortWiring& wiring, ByteLink& link, Instant since,
                                 Instant now);
    bool is_long(const PortWiring& wiring, Duration absence) const;
    void write_outputs(Instant now);
    WriteStatus hand_over(Link& link, std::size_t lane, const Transmission& sent, Duration period,
                          Instant now);
    static void capture(const Port& port, const Transmission& sent, Instant at);
    Instant advance_values(Instant now);
    void write_nodes(Instant now);
    /// Returns when the links want to be called again.
    Instant poll_can_links(Instant now);
    Instant advance(Instant now);
    void look_at_lines(Instant now);
    void publish(Instant now);
    void publish_arrivals();
    void publish_input(std::size_t index, Instant now);
    void publish_output(std::size_t index, Instant now);
    void publish_values();
    void publish_can_status();
    /// Returns how many ports are ready; their numbers are in `ready_`. Reads the clock.
    std::size_t wait(Instant until);
    std::size_t wait_until(Instant until);

    static constexpr std::size_t kEventsPerWake = 64;
    /// A receive buffer of the kernel has been read by then, and no sender holds up the others.
    static constexpr int kMostReads = 64;

    Engine& engine_;
    LoopSettings settings_;
    std::deque<Port> ports_;
    std::vector<Route> routes_;
    /// Ports that are CAN interfaces.
    std::vector<std::size_t> can_ports_;
    /// The port of each sensor bus.
    std::vector<std::size_t> bus_ports_;
    std::size_t quiet_ports_ = 0;
    UniqueFd epoll_;
    bool has_epoll_pwait2_ = true;
    UniqueFd wake_up_;
    std::atomic<bool> end_requested_{false};
    /// Written before the flag is set, and only read after it.
    Leaving leaving_;
    std::atomic<bool> retire_requested_{false};
    std::atomic<bool> retired_{false};
    bool retiring_ = false;
    Instant retire_until_ = kNever;
    std::atomic<Loop*> successor_{nullptr};
    /// From the loop before; set by its `hand_over_to`.
    LoopCarry carry_;
    bool took_over_ = false;
    std::array<std::size_t, kEventsPerWake> ready_{};
    /// The latest reading of the clock.
    Instant clock_{};
    /// Whatever had come until then has been read.
    Instant read_until_{};
    /// How much later than it should the latest wait ended.
    Duration late_by_{};
    /// It was cut short by something that happened to the thread.
    bool interrupted_ = false;
    AbsenceStatus absence_;
    Snapshot<AbsenceStatus> absence_status_;
    Reception reception_;
    CanReception can_reception_;
    Instant next_publish_{};
    std::atomic<std::int64_t> published_at_ns_{0};
    std::deque<std::atomic<std::int64_t>> newest_at_ns_;
    /// The latest ones that the engine knows.
    LineLevels levels_ = kNoLineActive;
    std::deque<Snapshot<InputStatus>> input_status_;
    std::deque<Snapshot<OutputStatus>> output_status_;
    std::deque<Snapshot<SensorBusState>> bus_states_;
    std::deque<Snapshot<ValueStatus>> value_status_;
    std::deque<Snapshot<dronecan::NodeReport>> node_reports_;
    /// They pass from loop to loop.
    std::vector<std::unique_ptr<InputTiming>> input_timing_;
    std::vector<std::unique_ptr<OutputTiming>> output_timing_;
};

}  // namespace tribus
