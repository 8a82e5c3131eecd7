#include "app/recorder/flight_recorder.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <set>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "app/client/control_socket.h"
#include "app/journal/log.h"
#include "app/recorder/left_recording.h"
#include "app/recorder/recording_plan.h"
#include "config/build/carry_over.h"
#include "pipelines/realtime/clock.h"

namespace tribus {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kKib = 1024;
constexpr std::uintmax_t kMib = std::uintmax_t{1024} * 1024;
/// Time of 256 bytes on an i.Bus line: the first read may hold bytes that began so long ago.
constexpr Duration kLongestBurst = std::chrono::milliseconds(23);

/// If the unit has several directories, the first one is its own.
std::string state_directory() {
    const char* given = std::getenv("STATE_DIRECTORY");
    const std::string all = given == nullptr ? "" : given;
    return all.substr(0, all.find(':'));
}

std::string ring_file(std::size_t number) {
    return fmt::format("{}.ring", number);
}

RecordingOrder order_for(const RecorderConfig& config, const fs::path& directory,
                         const RecordingPlan& plan, const RecordedEvent& event,
                         Duration wall_offset) {
    RecordingOrder order;
    order.directory = directory;
    order.kind = event.kind;
    order.reason = event.reason;
    order.zero = std::max(plan.begin, event.at - config.before);
    order.zero_wall = wall_offset + order.zero.time_since_epoch();
    order.event_wall = event.wall;
    order.ports = plan.ports;
    order.files = plan.files;
    order.replay = plan.replay;
    order.lacks = plan.lacks;
    order.keep = static_cast<std::size_t>(config.keep);
    order.space = static_cast<std::uintmax_t>(config.space_mib) * kMib;
    return order;
}

/// Reads what the process before this one had in memory.
tl::expected<PreparedRecording, std::string> prepare_left(const RecorderConfig& config,
                                                          const fs::path& directory,
                                                          const fs::path& folder, Instant now,
                                                          Duration wall_now) {
    remove_unfinished_recordings(directory);
    const auto age = age_of_latest(directory, "crash", wall_now);
    if (age && *age < config.pause) {
        return tl::unexpected<std::string>("a crash was recorded a moment ago");
    }
    auto left = read_left_recording(folder, now);
    if (!left) {
        return tl::unexpected(left.error());
    }
    const Duration wall_offset = wall_now - now.time_since_epoch();
    PreparedRecording crash{
        .order = order_for(config, directory, left->plan,
                           {.kind = "crash",
                            .reason = "the process before this one crashed or was killed",
                            .wall = wall_offset + left->latest.time_since_epoch(),
                            .at = left->latest,
                            .due = left->latest},
                           wall_offset),
        .kept = std::move(left->memories),
        .rings = std::move(left->rings)};
    crash.order.end = now;
    return crash;
}

/// A job that writes nothing.
tl::expected<PreparedRecording, std::string> only_tidy(const fs::path& directory) {
    remove_unfinished_recordings(directory);
    return tl::unexpected(std::string());
}

}  // namespace

FlightRecorder::FlightRecorder(RecorderConfig config, fs::path directory,
                               std::optional<RingDirectory> ring_directory)
    : config_(std::move(config)),
      directory_(std::move(directory)),
      ring_directory_(std::move(ring_directory)) {}

tl::expected<std::unique_ptr<FlightRecorder>, std::string> FlightRecorder::make(
    const Configuration& configuration, DiskPatience patience) {
    const RecorderConfig& config = *configuration.recorder;
    const std::string directory = config.directory.empty() ? state_directory() : config.directory;
    if (directory.empty()) {
        return tl::unexpected(
            fmt::format("{}:{}:{}: [recorder] has no directory for recordings, and "
                        "$STATE_DIRECTORY is not set; add directory = \"/some/folder\"",
                        configuration.file, config.where.line, config.where.column));
    }
    auto ring_directory =
        RingDirectory::open(SocketDirectories::of_this_process().runtime_directory);
    log_info("recorder: recordings go to {}{}", directory,
             ring_directory ? ""
                            : fmt::format("; a crash loses everything that is not written yet: {}",
                                          ring_directory.error()));
    std::unique_ptr<FlightRecorder> recorder(new FlightRecorder(
        config, directory,
        ring_directory ? std::optional(std::move(*ring_directory)) : std::nullopt));
    recorder->write_left(monotonic_now(), wall_time_now(), patience);
    return recorder;
}

/// Writes what the previous process had in memory, if it crashed or was killed. The job reads it
/// too: no frame waits for what may be long or damaged.
void FlightRecorder::write_left(Instant now, Duration wall_now, DiskPatience patience) {
    auto folder = ring_directory_ ? ring_directory_->take_left() : std::nullopt;
    if (!folder && patience == DiskPatience::waits) {
        remove_unfinished_recordings(directory_);
        return;
    }
    if (!folder) {
        job_ = RecordingJob::start([directory = directory_] { return only_tidy(directory); });
        return;
    }
    job_is_left_ = true;
    job_ = RecordingJob::start(
        [config = config_, directory = directory_, now, wall_now, folder = std::move(*folder)] {
            return prepare_left(config, directory, folder, now, wall_now);
        });
    job_number_ = 0;
}

bool FlightRecorder::finish(Instant now, Duration wall_now) {
    if (failsafe_) {
        failsafe_->due = std::min(failsafe_->due, now);
    }
    run_jobs(now, wall_now);
    return !pending();
}

FlightRecorder::~FlightRecorder() {
    for (int jobs = 0; jobs < 3 && pending(); ++jobs) {
        if (job_) {
            end_job();
        }
        finish(monotonic_now(), wall_time_now());
    }
}

tl::expected<RingMemory, std::string> FlightRecorder::memory_for(const std::string& device,
                                                                 fs::path& file,
                                                                 std::size_t bytes) {
    if (!ring_directory_) {
        return RingMemory::anonymous(bytes);
    }
    auto memory = RingMemory::in_file(file, bytes);
    if (memory) {
        return memory;
    }
    auto anonymous = RingMemory::anonymous(bytes);
    if (anonymous) {
        log_warning("recorder: a crash loses the recording of {}: {}", device, memory.error());
        file.clear();
    }
    return anonymous;
}

CaptureRing* FlightRecorder::ring_for(const PortPlan& port, const RecorderConfig& config) {
    const std::size_t bytes = static_cast<std::size_t>(config.memory_kib) * kKib;
    for (const auto& port_ring : port_rings_) {
        if (port_ring->bytes == bytes && same_device(port_ring->device, port.config)) {
            return &port_ring->ring;
        }
    }
    fs::path file =
        ring_directory_ ? ring_directory_->path() / ring_file(files_made_++) : fs::path();
    auto memory = memory_for(port.config.device, file, bytes);
    if (!memory) {
        const std::string lack = fmt::format("{}: {}", port.config.device, memory.error());
        log_warning("recorder: no {} KiB of memory for a port; not recorded: {}", config.memory_kib,
                    lack);
        lacks_[port.config.device] = lack;
        return nullptr;
    }
    lacks_.erase(port.config.device);
    CaptureRing ring = CaptureRing::create(memory->span());
    port_rings_.push_back(
        std::make_unique<PortRing>(PortRing{port.config, bytes, file, std::move(*memory), ring}));
    return &port_rings_.back()->ring;
}

void FlightRecorder::record_ports(const Configuration& configuration,
                                  const std::vector<PortPlan>& ports, Instant now) {
    begin_ = begin_.value_or(now - kLongestBurst);
    config_ = *configuration.recorder;
    std::vector<PortPlan> recorded;
    std::vector<std::string> lacks;
    std::vector<std::unique_ptr<PortRing>> before = std::exchange(port_rings_, {});
    for (const PortPlan& port : ports) {
        const auto port_ring = std::ranges::find_if(before, [&](const auto& candidate) {
            return candidate && &candidate->ring == port.wiring.capture;
        });
        if (port_ring != before.end()) {
            port_rings_.push_back(std::move(*port_ring));
            recorded.push_back(port);
        } else {
            lacks.push_back(lacks_[port.config.device]);
        }
    }
    plan_ = plan_recording(configuration, recorded, *begin_);
    plan_.lacks = std::move(lacks);
    for (std::size_t i = 0; i < port_rings_.size(); ++i) {
        plan_.ports[i].ring_file = port_rings_[i]->file.filename();
    }
    for (auto& port_ring : before) {
        retire(std::move(port_ring));
    }
    write_plan();
}

void FlightRecorder::retire(std::unique_ptr<PortRing> port_ring) {
    if (!port_ring) {
        return;
    }
    std::error_code ignored;
    if (!port_ring->file.empty()) {
        fs::remove(port_ring->file, ignored);
    }
    if (job_) {
        retired_.push_back(std::move(port_ring));
    }
}

/// Writes the plan, which tells a process after a crash which ring belongs to which port.
void FlightRecorder::write_plan() const {
    if (!ring_directory_) {
        return;
    }
    RecordingPlan outliving = plan_;
    std::erase_if(outliving.ports, [](const RecordedPort& port) { return port.ring_file.empty(); });
    std::string text = plan_to_text(outliving);
    if (text.size() > kMostPlanBytes) {
        outliving.files.clear();
        outliving.lacks.emplace_back("the configuration and its files, which are too long");
        text = plan_to_text(outliving);
    }
    std::error_code ignored;
    const fs::path fresh = ring_directory_->path() / "plan.new";
    std::ofstream file(fresh, std::ios::binary);
    file << text;
    if (file.flush()) {
        fs::rename(fresh, ring_directory_->path() / kRecordingPlanFile, ignored);
    }
}

RecordingOrder FlightRecorder::order(const Event& event, Duration wall_offset) const {
    return order_for(config_, directory_, plan_, event, wall_offset);
}

void FlightRecorder::note_failsafes(std::span<const FailsafeEntry> all) {
    const auto first = std::ranges::find_if(
        all, [this](const FailsafeEntry& entry) { return entry.at >= quiet_until_; });
    const std::span entries(first, all.end());
    if (entries.empty() || !config_.on_failsafe || failsafe_) {
        return;
    }
    std::set<std::string> names;
    for (const FailsafeEntry& entry : entries) {
        names.insert(entry.output);
    }
    failsafe_ = Event{.kind = "failsafe",
                      .reason = fmt::format("failsafe of output {}", fmt::join(names, ", ")),
                      .wall = entries.front().wall,
                      .at = entries.front().at,
                      .due = later(entries.front().at, config_.after)};
    quiet_until_ = later(failsafe_->due, config_.pause);
}

void FlightRecorder::look(std::span<const FailsafeEntry> entries, Instant now, Duration wall_now) {
    note_failsafes(entries);
    run_jobs(now, wall_now);
}

void FlightRecorder::run_jobs(Instant now, Duration wall_now) {
    if (job_ && job_->done()) {
        end_job();
    }
    for (std::optional<Event>* waiting : {&request_, &failsafe_}) {
        if (!job_ && *waiting && now >= (*waiting)->due) {
            begin(*std::exchange(*waiting, std::nullopt), now, wall_now);
        }
    }
}

void FlightRecorder::begin(const Event& event, Instant now, Duration wall_now) {
    if (plan_.ports.empty()) {
        if (event.number != 0) {
            outcomes_[event.number] = {
                .done = true,
                .result = tl::unexpected(
                    fmt::format("no port is recorded ({})", fmt::join(plan_.lacks, "; ")))};
        }
        return;
    }
    job_ = RecordingJob::start(order(event, wall_now - now.time_since_epoch()));
    job_number_ = event.number;
}

void FlightRecorder::end_job() {
    while (!job_->done()) {
        const timespec pause{.tv_sec = 0, .tv_nsec = 1'000'000};
        ::nanosleep(&pause, nullptr);
    }
    const RecordingOrder& order = job_->order();
    const RecordingJob::Result& result = job_->result();
    if (!job_->prepared() && result.error().empty()) {
        // There was nothing to write.
    } else if (!job_->prepared()) {
        log_warning(
            "recorder: the process before this one crashed or was killed; nothing of it is "
            "written: {}",
            result.error());
    } else if (result) {
        log_info("recorder: wrote {}: {}", result->string(), order.reason);
    } else {
        log_error(
            "recorder: cannot write the recording \"{}\": {}; everything else goes on, and so does "
            "recording; free some space, or set another directory in [recorder]",
            order.reason, result.error());
    }
    if (std::exchange(job_is_left_, false)) {
        result || !job_->prepared() ? ring_directory_->remove_left()
                                    : ring_directory_->put_left_back();
    }
    if (job_number_ != 0) {
        outcomes_[job_number_] = {.done = true, .result = result};
    }
    job_.reset();
    retired_.clear();
}

}  // namespace tribus
