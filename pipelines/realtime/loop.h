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
#include "pipelines/realtime/snapshot.h"
#include "transports/links/can_link.h"
#include "transports/links/link.h"
#include "transports/links/unique_fd.h"

namespace tribus {

/// How one port is joined to the engine. One serial device may serve an input and an output, one
/// CAN interface many of each.
struct PortWiring {
    std::vector<std::size_t> inputs;
    std::vector<std::size_t> outputs;
};

/// What the main thread may know of an input.
struct InputStatus {
    ChannelFrame latest;
    InputCounts counts;
    std::uint64_t rejected = 0;
    std::uint64_t skipped_bytes = 0;
    Duration interval{};
    bool alive = false;
    bool ever_good = false;
};

/// What the main thread may know of an output.
struct OutputStatus {
    ChannelFrame latest;
    OutputCounts counts;
    std::uint64_t overruns = 0;
    OutputStage stage = OutputStage::failsafe;
};

/// Drives an engine in real time: waits for bytes and deadlines, reads the clock once a wake, reads
/// all that is ready, lets the engine run, and writes what is due. One thread, the data thread,
/// calls `run` and owns every link that is in use; it never waits for another thread and does not
/// allocate. The rest is for the main thread, as each function says.
class Loop {
  public:
    /// Wants a link for each wiring; none where the device is missing and will be given.
    Loop(Engine& engine, std::vector<PortWiring> wiring, std::vector<std::unique_ptr<Link>> links);
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

    /// Thread-safe.
    InputStatus input_status(std::size_t input) const { return input_status_[input].read(); }
    OutputStatus output_status(std::size_t output) const { return output_status_[output].read(); }
    /// Of a port that is a CAN interface.
    CanLinkStatus can_status(std::size_t port) const { return ports_[port].can_status.read(); }

  private:
    struct Port {
        PortWiring wiring;
        std::unique_ptr<Link> link;
        std::atomic<Link*> lost{nullptr};
        std::atomic<Link*> given{nullptr};
        Snapshot<CanLinkStatus> can_status;
    };

    void watch(std::size_t port);
    void lose(Port& port);
    void accept_given_links();
    void read_port(Port& port, Instant now);
    ReadStatus read_bytes(const PortWiring& wiring, ByteLink& link, Instant now);
    ReadStatus read_can(const PortWiring& wiring, CanLink& link, Instant now);
    void write_outputs(Instant now);
    /// Returns when the links want to be called again.
    Instant poll_can_links(Instant now);
    Instant advance(Instant now);
    void publish(Instant now);
    /// Returns how many ports are ready; their numbers are in `ready_`.
    std::size_t wait(Instant now, Instant until);

    static constexpr std::size_t kEventsPerWake = 64;

    Engine& engine_;
    std::deque<Port> ports_;
    UniqueFd epoll_;
    UniqueFd wake_up_;
    std::atomic<bool> end_requested_{false};
    std::array<std::size_t, kEventsPerWake> ready_{};
    Reception reception_;
    CanReception can_reception_;
    Instant next_publish_{};
    std::deque<Snapshot<InputStatus>> input_status_;
    std::deque<Snapshot<OutputStatus>> output_status_;
};

}  // namespace tribus
