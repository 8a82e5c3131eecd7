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

#include "app/recorder/recording_folder.h"
#include "app/recorder/recording_job.h"
#include "app/recorder/recording_plan.h"
#include "app/recorder/ring_memory.h"
#include "config/build/build.h"
#include "config/schema/schema.h"
#include "core/time.h"
#include "pipelines/realtime/capture_ring.h"

namespace tribus {

/// Why there is a recording.
struct RecordedEvent {
    std::string kind;
    std::string reason;
    Duration wall{};
    Instant at{};
    Instant due{};
    std::uint64_t number = 0;  ///< 0: not requested by a client
};

/// An output went into failsafe.
struct FailsafeEntry {
    std::string output;
    Instant at{};
    Duration wall{};
};

/// Whether somebody waits for a disk that does not answer.
enum class DiskPatience : std::uint8_t { waits, does_not_wait };

/// Keeps what passes the ports in memory. Writes the latest of it to a folder when an output goes
/// into failsafe, on request, and after a crash of the previous process. Another thread writes, so
/// a slow disk delays neither the data thread nor the main thread. Thread-bound to the main thread.
class FlightRecorder {
  public:
    /// `configuration` must have [recorder]. The error is `file:line:column: text`.
    static tl::expected<std::unique_ptr<FlightRecorder>, std::string> make(
        const Configuration& configuration, DiskPatience patience = DiskPatience::waits);
    FlightRecorder(const FlightRecorder&) = delete;
    FlightRecorder& operator=(const FlightRecorder&) = delete;
    /// Writes the recordings that are still pending, and waits for that. The data thread must have
    /// ended.
    ~FlightRecorder();
    /// Writes them without waiting. Returns true once none is pending. The data thread no longer
    /// uses its rings. Call it a few times a second.
    bool finish(Instant now, Duration wall_now);

    /// The ring of this device: the present one or a new one. Null if there is no memory for it;
    /// the log says so. It stays valid until a `record_ports` without it.
    CaptureRing* ring_for(const PortPlan& port, const RecorderConfig& config);
    /// From now on the recorder records these ports and frees the rings of others, which the data
    /// thread must no longer use.
    void record_ports(const Configuration& configuration, const std::vector<PortPlan>& ports,
                      Instant now);

    /// The folder of the recordings.
    const std::filesystem::path& directory() const { return directory_; }

    /// Call it a few times a second, with the entries since the last call, the oldest first.
    void look(std::span<const FailsafeEntry> entries, Instant now, Duration wall_now);

    /// Answers the requests `record`, which begins a recording, and `record NUMBER`, which returns
    /// its state. The answer is a JSON object.
    std::string answer(std::span<const std::string> words, Instant now, Duration wall_now);

  private:
    struct PortRing {
        PortConfig device;
        std::size_t bytes = 0;
        std::filesystem::path file;
        RingMemory memory;
        CaptureRing ring;
    };
    using Event = RecordedEvent;
    /// Outcome of a requested recording.
    struct Outcome {
        bool done = false;
        RecordingJob::Result result{};
    };

    FlightRecorder(RecorderConfig config, std::filesystem::path directory,
                   std::optional<RingDirectory> ring_directory);
    tl::expected<RingMemory, std::string> memory_for(const std::string& device,
                                                     std::filesystem::path& file,
                                                     std::size_t bytes);
    RecordingOrder order(const Event& event, Duration wall_offset) const;
    void write_left(Instant now, Duration wall_now, DiskPatience patience);
    bool pending() const { return job_ || failsafe_ || request_; }
    void note_failsafes(std::span<const FailsafeEntry> all);
    void begin(const Event& event, Instant now, Duration wall_now);
    void end_job();
    void retire(std::unique_ptr<PortRing> port_ring);
    void write_plan() const;
    void run_jobs(Instant now, Duration wall_now);

    RecorderConfig config_;
    std::filesystem::path directory_;
    std::optional<RingDirectory> ring_directory_;
    std::vector<std::unique_ptr<PortRing>> port_rings_;
    /// No longer written to, but a job may still read them.
    std::vector<std::unique_ptr<PortRing>> retired_;
    /// When this process began to record.
    std::optional<Instant> begin_;
    std::size_t files_made_ = 0;
    /// By device: why it is not recorded.
    std::map<std::string, std::string> lacks_;
    RecordingPlan plan_;
    std::optional<Event> failsafe_;
    std::optional<Event> request_;
    Instant quiet_until_{};
    std::unique_ptr<RecordingJob> job_;
    /// The job writes what a crashed process left.
    bool job_is_left_ = false;
    std::uint64_t job_number_ = 0;
    std::uint64_t requests_ = 0;
    std::map<std::uint64_t, Outcome> outcomes_;
};

/// Answers the request `recordings`, which asks for the folder of the recordings. Null for
/// `recorder`: the configuration has none.
std::string recordings_json(const FlightRecorder* recorder);

}  // namespace tribus
