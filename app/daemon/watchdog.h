#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/time.h"

namespace tribus {

/// Progress of an output at one publication of the data thread.
struct OutputProgress {
    Instant due{};  ///< when its next frame is due
    Duration period{};
    std::uint64_t overruns = 0;
};

/// Another part than the data thread that stands, and which one.
struct Standing {
    enum class Part : std::uint8_t { none, port_unheard, link_thread, gpio_thread };
    Part part = Part::none;
    std::size_t port = 0;

    bool operator==(const Standing&) const = default;
};

/// Whether the outputs are on time, and what is late if they are not.
enum class Punctuality : std::uint8_t {
    on_time,
    data_thread_stands,
    part_stands,
    output_late,
};

/// Decides whether the service manager may be told that all is well: only while the data thread
/// runs and each output makes its frames on time. An output that sends nothing, because its
/// failsafe is silence or because the port takes nothing, still counts as on time: a restart would
/// not help. Nor may another part stand: a port that nobody hears, the thread of a link, that of
/// the GPIO lines. Only what it could see counts: not the time before the first look, nor that in
/// which the whole program stood. Pure; thread-bound.
class Watchdog {
  public:
    /// `limit`: the service manager restarts the program after so long without notification.
    explicit Watchdog(Duration limit) : limit_(limit) {}

    /// Call it when a data thread starts, with counters from zero.
    void restart();

    /// Call it a few times a second. `published`: when the data thread last published. Returns true
    /// if the service manager is to be notified now.
    bool look(Instant now, Instant published, std::span<const OutputProgress> outputs,
              const Standing& standing = {});

    /// Result of the latest `look`.
    Punctuality punctuality() const { return punctuality_; }
    /// Index of the late output, if `punctuality` is `output_late`.
    std::size_t late_output() const { return late_output_; }
    /// The part that stands, if `punctuality` is `part_stands`.
    const Standing& standing() const { return standing_; }

  private:
    struct Seen {
        OutputProgress progress{};
        bool missed_half = false;  ///< of its turns before the latest publication
    };
    void watch(Instant now, Instant published, const Standing& standing);
    Punctuality judge(Instant published, std::span<const OutputProgress> outputs);

    Duration limit_;
    Instant next_notification_{};
    std::optional<Instant> looked_at_;
    std::optional<Instant> watched_;  ///< the publication that the latest look found
    Duration watched_for_{};
    Standing standing_;
    Duration stands_for_{};
    std::optional<Instant> judged_;
    Instant compares_from_{};  ///< what was published before lies in a stop or before one
    std::vector<Seen> outputs_;
    Punctuality punctuality_ = Punctuality::on_time;
    std::size_t late_output_ = 0;
};

}  // namespace tribus
