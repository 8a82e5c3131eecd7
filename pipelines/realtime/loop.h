#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "core/channel_frame.h"
#include "core/time.h"
#include "pipelines/engine/carry_over.h"
#include "pipelines/engine/engine.h"
#include "pipelines/engine/read_pacer.h"
#include "pipelines/realtime/capture_ring.h"
#include "pipelines/realtime/change_ring.h"
#include "pipelines/realtime/line_exchange.h"
#include "pipelines/realtime/machine_numbers.h"
#include "pipelines/realtime/port_waits.h"
#include "pipelines/realtime/snapshot.h"
#include "pipelines/realtime/timing.h"
#include "pipelines/rules/line_words.h"
#include "pipelines/stations/stations.h"
#include "pipelines/values/value_engine.h"
#include "transports/links/can/can_link.h"
#include "transports/links/link.h"

namespace tribus {

/// The stations on one port, and how the port is read.
struct PortWiring {
    std::vector<Station> stations{};
    /// Duration of one byte on the wire. Zero if unknown or meaningless.
    Duration byte_time{};
    /// Each read is a datagram: no frame goes on beyond it.
    bool has_datagrams = false;
    /// One of the stations answers what it receives.
    bool answers = false;
    /// Records all that passes, with the same times that the engine gets. Null: nothing is
    /// recorded. Must outlive the loop.
    CaptureRing* capture = nullptr;
};

/// How a port of a new loop continues from the loop before.
struct PortCarry {
    /// Index of the port with the same device or interface in the loop before.
    CarriedFrom from{};
    /// Takes the open link with the bytes that wait in it. Otherwise it has its own, or will be
    /// given one.
    bool takes_link = false;
    /// Nobody has read this link before: the bytes that wait in it are old.
    bool discards_unread = false;
};

/// How a loop continues from the loop before.
struct LoopCarry {
    EngineCarry engine;
    ValueCarry values;
    std::vector<PortCarry> ports;
};

struct LoopSettings {
    /// For this time before a deadline the thread polls the clock instead of sleeping.
    Duration spin{};
    /// Null if no GPIO lines are configured. Must outlive the loop.
    LineExchange* lines = nullptr;
    /// Null if no sensor buses or values are configured. Must outlive the loop.
    ValueEngine* values = nullptr;
    /// Facts of the machine from the main thread. Must outlive the loop.
    const MachineNumbers* machine = nullptr;
};

/// Upper limit of the number of reject causes of a decoder.
inline constexpr std::size_t kMostRejectCauses = 12;

/// Figures of an input, published for the main thread.
struct InputFigures {
    /// When the data thread published it.
    Instant at{};
    ChannelFrame latest;
    /// When the newest frame came, which may be later than `at`.
    Instant newest_at{};
    InputCounts counts;
    std::uint64_t rejected = 0;
    /// By cause, in the order of the decoder's names.
    std::array<std::uint64_t, kMostRejectCauses> rejected_by{};
    std::uint64_t skipped_bytes = 0;
    Duration interval{};
    /// `unproved` instead of `good` while no output can use its frames.
    LinkState state;
    std::uint64_t implausible_frames = 0;
    bool ever_good = false;
    bool two_senders = false;  ///< the decoder sees two senders with its ids
};

/// What an input says of frames that do not count. Published while there are some.
struct FrameFaults {
    ImplausibleFrames implausible;
    FaultText fault;
};

/// State of an input.
struct InputStatus : InputFigures, FrameFaults {};

/// Figures of an output, published for the main thread.
struct OutputFigures {
    /// When the data thread published it.
    Instant at{};
    ChannelFrame latest;
    OutputCounts counts;
    std::uint64_t overruns = 0;
    OutputState state;
    Instant stage_since{};
    /// When the next frame is due, and the period.
    Instant due{};
    Duration period{};
    /// Whether the latest run made a frame. A silent output makes none.
    bool sends = false;
    /// What was heard of the receiver of its frames.
    Answers answers{};
};

/// State of an output.
struct OutputStatus : OutputFigures {
    /// Published while it is not in control.
    OutputWait wait;
};

/// How often the data thread did not run for 100 ms or longer, the default timeout of an input: it
/// was stopped, starved of processor time, or suspended with the machine.
struct AbsenceStatus {
    std::uint64_t count = 0;
    Duration latest{};
};

/// A port that does not do its part though the data thread runs.
struct StandingPort {
    enum class Fault : std::uint8_t {
        none,
        unheard,  ///< what comes is not reported: it was found by a look without a report
        thread,   ///< the link's own thread stands (`Link::stands`)
    };
    Fault fault = Fault::none;
    std::size_t port = 0;
};

/// State of a named value, published for the main thread.
struct ValueStatus {
    double number = 0;
    Instant at{};            ///< of `number`
    bool ever = false;       ///< it had a number before
    bool available = false;  ///< its source has a number now, stale or not
    ValueGaps gaps{};
};

/// Drives an engine in real time: waits for bytes and deadlines, reads all that is ready, runs the
/// engine and writes what is due. It reads the clock at each wake-up, before and after each write
/// (for the latency), and before it sleeps. After a late wake-up the ports hold old bytes: it reads
/// all of them before it writes anything. One thread, the data thread, calls `run` and owns every
/// link in use; it never waits for another thread and does not allocate. All other functions are
/// for the main thread, except where a comment says otherwise.
class Loop {
  public:
    /// `links` has one link for each wiring, null if the device is missing and will be given later.
    Loop(Engine& engine, std::vector<PortWiring> wiring, std::vector<std::unique_ptr<Link>> links,
         LoopSettings settings = {});
    Loop(const Loop&) = delete;
    Loop& operator=(const Loop&) = delete;
    ~Loop();

    /// Creates the descriptors that the loop waits for. Main thread, before `run`. The error is a
    /// sentence.
    tl::expected<void, std::string> prepare();

    /// Runs the loop. Returns null after `request_end`, when every output has sent its last frames
    /// or a second is over, and when the kernel refuses to wait (`failure`). Returns the next loop
    /// after `hand_over_to`. Data thread.
    Loop* run();

    /// These parts enter failsafe, send their last frames and end; the others go on. Call once,
    /// before `hand_over_to`. Main thread.
    void retire(Leaving leaving);
    /// Whether they have sent their last frames. Thread-safe.
    bool retired() const { return retired_.load(std::memory_order_acquire); }
    /// Discards the bytes that wait in the links of a loop that has not run yet, because the
    /// running loop receives them too. Main thread.
    void discard_unread();
    /// `next`, which is prepared and has never run, replaces this loop between two frames. This
    /// loop is no longer used after `run` has returned; it still holds the links that `next` did
    /// not take. Both must live until then. Main thread.
    void hand_over_to(Loop& next, LoopCarry carry);

    /// Thread-safe.
    void request_end();
    /// Why the loop ended though nobody asked for it: a value of errno. 0: it did not. Thread-safe.
    int failure() const { return wait_failure_.load(std::memory_order_acquire); }

    /// The link of `port` that the data thread has given up because its device is gone. Null if
    /// there is none, or it was taken before. Main thread.
    std::unique_ptr<Link> take_lost(std::size_t port);
    /// Gives a new link in place of one that was taken by `take_lost`. Main thread.
    void give(std::size_t port, std::unique_ptr<Link> link);

    /// Thread-safe, as all below. Each value is as old as the latest publication.
    InputStatus input_status(std::size_t input) const;
    OutputStatus output_status(std::size_t output) const;
    const InputTiming& input_timing(std::size_t input) const { return *input_timing_[input]; }
    const OutputTiming& output_timing(std::size_t output) const { return *output_timing_[output]; }
    SensorBusState bus_state(std::size_t bus) const { return bus_states_[bus].read(); }
    /// When the data thread last published all of this. A data thread that hangs no longer does.
    Instant published_at() const {
        return Instant(Duration(published_at_ns_.load(std::memory_order_acquire)));
    }
    AbsenceStatus absence() const { return absence_status_.read(); }
    /// Changes of state of all parts, also those of the loop before. Up to the number
    /// `changes_before` the indices are those of that one.
    const ChangeRing& changes() const { return *changes_; }
    std::uint64_t changes_before() const { return changes_before_; }
    /// The first port that stands.
    StandingPort standing_port() const { return standing_port_.read(); }
    /// Indices on the board.
    std::size_t value_count() const { return value_status_.size(); }
    ValueStatus value_status(std::size_t value) const { return value_status_[value].read(); }
    dronecan::NodeReport node_report(std::size_t node) const { return node_reports_[node].read(); }
    /// For a port that is a CAN interface.
    CanLinkStatus can_status(std::size_t port) const { return ports_[port].can_status.read(); }

  private:
    struct Port {
        PortWiring wiring;
        std::unique_ptr<Link> link;
        /// Moves with the link. Nothing: the link has no descriptor.
        std::optional<PortWaits::Watch> watch;
        std::atomic<Link*> lost{nullptr};
        std::atomic<Link*> given{nullptr};
        Snapshot<CanLinkStatus> can_status;
        CanBusState told_bus = CanBusState::ready;
        ReadPacer pacer{Duration::zero()};
        /// The port is not watched until then. `kNever`: it is watched.
        Instant quiet_until = kNever;
        /// The link was reported as ready since the latest look at silent ports.
        bool reported = false;
        /// It was read since then because the thread was late. A report may have been on its way,
        /// so the next look would prove nothing.
        bool caught_up = false;
        /// How many of these looks in a row found what was not reported.
        int unheard = 0;
    };
    /// Port and lane of a station that sends.
    struct Route {
        std::size_t port = 0;
        std::size_t lane = 0;
    };

    void begin();
    static void set_event(int event);
    Loop* successor(Instant now);
    void take_over(Loop& before, Instant now);
    void take_ports(Loop& before, Instant now);
    void take_link(std::size_t port, Port& before, const PortCarry& carry, Instant now);
    void read_second_sockets(Loop& before, Instant now);
    void discard_unread_of(Link& link, Instant now);
    void watch(std::size_t port);
    void set_watched(std::size_t port, bool watched);
    void watch_again(std::size_t port);
    void end_watch(Port& port);
    void lose(Port& port);
    void set_device_present(const Port& port);
    void set_devices_present();
    void accept_given_links();
    void read_port(std::size_t port, Instant now);
    bool read_unreported(Port& port, Instant since, Instant now);
    void look_at_silent_ports(Instant now);
    void read_quiet_ports(Instant now);
    ReadStatus read_bytes(std::size_t port, ByteLink& link, Instant now);
    ReadStatus read_can(const PortWiring& wiring, CanLink& link, Instant now);
    void answer(const PortWiring& wiring, Link& link, Instant now);
    void answer_can_frames(Instant now);
    bool end_datagram(const PortWiring& wiring, Instant at);
    bool hand_on_bytes(const PortWiring& wiring, Instant at);
    void hand_on_can(const PortWiring& wiring);
    void end_quiet(std::size_t port);
    void catch_up(Instant since, Instant now);
    ReadStatus catch_up_on_bytes(const PortWiring& wiring, ByteLink& link, Instant since,
                                 Instant now);
    void send_ready(Instant now);
    void send(Station station, const Transmission& sent, Instant now);
    WriteStatus hand_over(Link& link, std::size_t lane, const Transmission& sent,
                          Duration valid_for, Instant now);
    static void capture(const PortWiring& wiring, const Transmission& sent, Instant at);
    void note_sent(std::size_t output, Instant now);
    /// Returns when to call `poll` of the links again.
    Instant poll_can_links(Instant now);
    void tell_bus(std::size_t port, Instant now);
    Instant advance(Instant now);
    void end_at_once(Instant now);
    void look_at_lines(Instant now);
    void publish(Instant now);
    void note_frame(std::size_t input, Instant at);
    void publish_input(std::size_t index, Instant now);
    void publish_output(std::size_t index, Instant now);
    void publish_values();
    void publish_can_status();
    void publish_standing_port(Instant now);
    /// Returns the number of ready ports; `ready_` has their indices. Reads the clock.
    std::size_t wait(Instant until);
    std::size_t wait_until(Instant until);
    void take_news(std::span<const std::uint32_t> ready);

    /// Limit of reads in a row. It empties the kernel's receive buffer and keeps one sender from
    /// blocking the other ports.
    static constexpr int kMostReads = 64;
    /// Limit of reads in a row that complete no frame, and the time until the next read: noise, and
    /// datagrams that somebody sends without the key, must delay nothing else.
    static constexpr int kMostFruitlessReads = 8;
    static constexpr Duration kFruitlessPause = std::chrono::microseconds(500);

    Engine& engine_;
    std::unique_ptr<ChangeRing> changes_ = std::make_unique<ChangeRing>();
    std::uint64_t changes_before_ = 0;
    LoopSettings settings_;
    Stations stations_;
    std::vector<Port> ports_;
    /// By kind and index of a station.
    std::array<std::vector<Route>, kStationKinds> routes_;
    /// Indices of the ports that are CAN interfaces.
    std::vector<std::size_t> can_ports_;
    std::size_t quiet_ports_ = 0;
    PortWaits waits_;
    /// Why the kernel refuses to wait: a value of errno.
    std::atomic<int> wait_failure_{0};
    std::atomic<bool> end_requested_{false};
    /// Written before the flag is set and read only after it.
    Leaving leaving_;
    std::atomic<bool> retire_requested_{false};
    std::atomic<bool> retired_{false};
    bool retiring_ = false;
    Instant retire_until_ = kNever;
    std::atomic<Loop*> successor_{nullptr};
    /// Set by `hand_over_to` of the loop before.
    LoopCarry carry_;
    bool took_over_ = false;
    std::array<std::uint32_t, PortWaits::kMostReady> ready_{};
    /// The latest reading of the clock.
    Instant clock_{};
    /// Everything that came until then has been read.
    Instant read_until_{};
    /// How late the latest wait ended.
    Duration late_by_{};
    AbsenceStatus absence_;
    Snapshot<AbsenceStatus> absence_status_;
    /// Another thread has set an event.
    bool event_came_ = true;
    Reception reception_;
    CanReception can_reception_;
    /// Frames came that a station may have to answer.
    bool can_answers_wait_ = false;
    Instant next_publish_{};
    Instant looked_at_ports_{};
    Snapshot<StandingPort> standing_port_;
    std::atomic<std::int64_t> published_at_ns_{0};
    std::vector<std::atomic<std::int64_t>> newest_at_ns_;
    /// The levels that the engine has.
    LineLevels levels_ = kNoLineActive;
    std::vector<Snapshot<InputFigures>> input_figures_;
    std::vector<Snapshot<FrameFaults>> frame_faults_;
    std::vector<Snapshot<OutputFigures>> output_figures_;
    std::vector<Snapshot<OutputWait>> output_waits_;
    std::vector<Snapshot<SensorBusState>> bus_states_;
    std::vector<Snapshot<ValueStatus>> value_status_;
    std::vector<Snapshot<dronecan::NodeReport>> node_reports_;
    /// They move from loop to loop.
    std::vector<std::unique_ptr<InputTiming>> input_timing_;
    std::vector<std::unique_ptr<OutputTiming>> output_timing_;
};

}  // namespace tribus
