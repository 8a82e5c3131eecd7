#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "app/recording_folder.h"
#include "app/recording_job.h"
#include "app/recording_plan.h"
#include "app/ring_memory.h"
#include "config/build.h"
#include "config/schema.h"
#include "core/time.h"
#include "pipelines/realtime/capture_ring.h"

namespace tribus {

/// Keeps what passes the ports in memory, and writes the latest of it to a folder when an output
/// goes into failsafe, when somebody asks, or, after a crash, what the process before left. What
/// the disk does concerns neither the data thread nor the main thread. Thread-bound to the main
/// thread.
class FlightRecorder {
  public:
    /// For a configuration with [recorder]. The error is `file:line:column: text`.
    static tl::expected<std::unique_ptr<FlightRecorder>, std::string> make(
        const Configuration& configuration);
    FlightRecorder(const FlightRecorder&) = delete;
    FlightRecorder& operator=(const FlightRecorder&) = delete;
    /// Writes what an event has asked for. After the data thread has ended.
    ~FlightRecorder();

    /// The ring of that device: the one that it has, or a fresh one. Null where there is no memory
    /// for it, which the log says. It is there until the next `settle` that does not name it.
    CaptureRing* ring_for(const PortPlan& port, const RecorderConfig& config);
    /// From now on it records these ports; rings of others are given back. The data thread must
    /// not use those any more.
    void settle(const Configuration& configuration, const std::vector<PortPlan>& ports,
                Instant now);

    /// A few times a second: with how often each output went into failsafe since it was made.
    void look(std::span<const std::uint64_t> failsafe_entries, Instant now, Duration wall_now);

    /// Answers `record`, which begins a recording and tells its number, and `record NUMBER`, which
    /// tells what came of it; an object of JSON.
    std::string answer(std::span<const std::string> words, Instant now, Duration wall_now);

  private:
    struct Tape {
        PortConfig device;
        std::size_t bytes = 0;
        std::filesystem::path file;
        RingMemory memory;
        CaptureRing ring;
    };
    struct Event {
        std::string kind;
        std::string reason;
        Duration wall{};
        Instant at{};
        Instant due{};
        std::uint64_t number = 0;  ///< 0: nobody asked for it
    };
    /// Of a recording that somebody asked for.
    struct Outcome {
        bool done = false;
        RecordingJob::Result result{};
    };

    FlightRecorder(RecorderConfig config, std::filesystem::path directory,
                   std::optional<RingHome> home);
    tl::expected<RingMemory, std::string> memory_for(const std::string& device,
                                                     std::filesystem::path& file,
                                                     std::size_t bytes);
    RecordingOrder order(const Event& event, Duration wall_offset) const;
    void write_left(Instant now, Duration wall_now);
    void note_failsafes(std::span<const std::uint64_t> entries, Instant now, Duration wall_now);
    void begin(const Event& event, Instant now, Duration wall_now);
    void end_job();
    void retire(std::unique_ptr<Tape> tape);
    void tell_successor() const;
    void tend(Instant now, Duration wall_now);

    RecorderConfig config_;
    std::filesystem::path directory_;
    std::optional<RingHome> home_;
    std::vector<std::unique_ptr<Tape>> tapes_;
    /// Nothing is written to them any more, but a job may still read them.
    std::vector<std::unique_ptr<Tape>> retired_;
    /// Since when this process records.
    std::optional<Instant> begin_;
    std::size_t files_made_ = 0;
    /// By device: why it is not recorded.
    std::map<std::string, std::string> lacks_;
    RecordingPlan plan_;
    std::vector<std::string> output_names_;
    std::vector<std::uint64_t> failsafe_entries_;
    std::optional<Event> failsafe_;
    std::optional<Event> request_;
    Instant quiet_until_{};
    std::unique_ptr<RecordingJob> job_;
    std::uint64_t job_number_ = 0;
    std::uint64_t requests_ = 0;
    std::map<std::uint64_t, Outcome> outcomes_;
};

}  // namespace tribus
