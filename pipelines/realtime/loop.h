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
#include "pipelines/engine.h"
#include "pipelines/line_words.h"
#include "pipelines/read_pacer.h"
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

/// What the main thread may know of an input.
struct InputStatus {
    ChannelFrame latest;
    InputCounts counts;
    std::uint64_t rejected = 0;
    std::uint64_t skipped_bytes = 0;
    Duration interval{};
    LinkState state;
    bool ever_good = false;
};

/// What the main thread may know of an output.
struct OutputStatus {
    ChannelFrame latest;
    OutputCounts counts;
    std::uint64_t overruns = 0;
    OutputState state;
    /// Its next turn, and how long it is from one to the next.
    Instant due{};
    Duration period{};
};

/// Drives an engine in real time: waits for bytes and deadlines, reads all that is ready, lets the
/// engine run, and writes what is due. It reads the clock at each wake, behind each write, which
/// tells the latency, and before it sleeps, so that it does not sleep longer. One thread, the data
/// thread, calls `run` and owns every link that is in use; it never waits for another thread and
/// does not allocate. The rest is for the main thread, as each function says.
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

    /// Data thread. Returns after `request_end`, when every output has said its last frames.
    void run();

    /// Thread-safe.
    void request_end();

    /// The link of `port` that the data thread has given up because its device is gone, if it has
    /// not been taken yet. Main thread.
    std::unique_ptr<Link> take_lost(std::size_t port);
    /// A fresh link for a port whose lost one was taken. Main thread.
    void give(std::size_t port, std::unique_ptr<Link> link);

    /// Thread-safe. When the status of all of them was told last.
    Instant published_at() const { return published_at_.load(std::memory_order_relaxed); }
    InputStatus input_status(std::size_t input) const { return input_status_[input].read(); }
    OutputStatus output_status(std::size_t output) const { return output_status_[output].read(); }
    const InputTiming& input_timing(std::size_t input) const { return input_timing_[input]; }
    const OutputTiming& output_timing(std::size_t output) const { return output_timing_[output]; }
    SensorBusState bus_state(std::size_t bus) const { return bus_states_[bus].read(); }
    dronecan::NodeReport node_report(std::size_t node) const { return node_reports_[node].read(); }
    /// Of a port that is a CAN interface.
    CanLinkStatus can_status(std::size_t port) const { return ports_[port].can_status.read(); }

  private:
    struct Port {
        PortWiring wiring;
        std::unique_ptr<Link> link;
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

    void watch(std::size_t port);
    void set_watched(std::size_t port, bool watched);
    void lose(Port& port);
    void accept_given_links();
    void read_port(std::size_t port, Instant now);
    void read_quiet_ports(Instant now);
    ReadStatus read_bytes(std::size_t port, ByteLink& link, Instant now);
    ReadStatus read_can(const PortWiring& wiring, CanLink& link, Instant now);
    void write_outputs(Instant now);
    Instant advance_values(Instant now);
    void write_nodes(Instant now);
    /// Returns when the links want to be called again.
    Instant poll_can_links(Instant now);
    Instant advance(Instant now);
    void look_at_lines(Instant now);
    void publish(Instant now);
    /// Returns how many ports are ready; their numbers are in `ready_`. Reads the clock.
    std::size_t wait(Instant until);
    std::size_t wait_until(Instant until);

    static constexpr std::size_t kEventsPerWake = 64;

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
    std::array<std::size_t, kEventsPerWake> ready_{};
    /// The latest reading of the clock.
    Instant clock_{};
    Reception reception_;
    CanReception can_reception_;
    Instant next_publish_{};
    std::atomic<Instant> published_at_{};
    /// The latest ones that the engine knows.
    LineLevels levels_ = kNoLineActive;
    std::deque<Snapshot<InputStatus>> input_status_;
    std::deque<Snapshot<OutputStatus>> output_status_;
    std::deque<Snapshot<SensorBusState>> bus_states_;
    std::deque<Snapshot<dronecan::NodeReport>> node_reports_;
    std::deque<InputTiming> input_timing_;
    std::deque<OutputTiming> output_timing_;
};

}  // namespace tribus
