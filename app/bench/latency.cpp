#include "app/bench/latency.h"

#include <poll.h>
#include <sys/epoll.h>

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "app/bench/tester.h"
#include "pipelines/realtime/clock.h"
#include "transports/links/unique_fd.h"

namespace tribus::bench {
namespace {

/// A frame that takes longer is lost; far longer than any stall of a machine.
constexpr Duration kLostAfter = std::chrono::milliseconds(500);

timespec as_timespec(Duration duration) {
    const Duration positive = std::max(duration, Duration::zero());
    const auto seconds = std::chrono::floor<std::chrono::seconds>(positive);
    timespec time{};
    time.tv_sec = seconds.count();
    time.tv_nsec = (positive - seconds).count();
    return time;
}

/// Sends one frame and waits for it.
std::optional<Duration> time_one_frame(Lane& lane) {
    lane.drain();
    if (!lane.send()) {
        return std::nullopt;
    }
    while (true) {
        pollfd out{.fd = lane.out_descriptor(), .events = POLLIN, .revents = 0};
        const timespec patience = as_timespec(lane.sent_at() + kLostAfter - monotonic_now());
        if (::ppoll(&out, 1, &patience, nullptr) <= 0) {
            lane.give_up();
            return std::nullopt;
        }
        const bool arrived = lane.receive();
        const Instant now = monotonic_now();
        if (arrived) {
            return now - lane.sent_at();
        }
    }
}

/// Absolute instants, one a period. One that comes late moves all that follow: frames closer to
/// each other than a period would wait for it in the subject.
class Beat {
  public:
    explicit Beat(Duration period) : period_(period), next_(monotonic_now() + period) {}
    void wait() {
        sleep_until(next_);
        const Instant now = monotonic_now();
        if (now - next_ > period_ / 8) {
            next_ = now;
        }
        next_ += period_;
    }

  private:
    Duration period_;
    Instant next_;
};

Duration used_by(const Subject& subject) {
    const auto usage = subject.usage();
    return usage ? usage->processor_time : Duration::zero();
}

LatencyResult result_of(const Subject& subject, std::vector<Duration> samples, Duration used) {
    LatencyResult result;
    result.lost = subject.lost();
    result.torn = subject.torn();
    if (!samples.empty()) {
        result.processor_time_per_frame = used / static_cast<std::int64_t>(samples.size());
    }
    result.latency = Distribution(std::move(samples));
    return result;
}

}  // namespace

std::vector<LatencyResult> measure_latency(std::span<Subject* const> subjects, Duration length) {
    const auto periods = static_cast<std::size_t>(std::max<std::int64_t>(1, length / kFramePeriod));
    std::vector<std::vector<Duration>> samples(subjects.size());
    std::vector<Duration> used_before;
    for (std::size_t i = 0; i < subjects.size(); ++i) {
        samples[i].reserve(periods);
        subjects[i]->lane().start_counting();
        used_before.push_back(used_by(*subjects[i]));
    }
    Beat beat(kFramePeriod);
    for (std::size_t period = 0; period < periods && !interrupted(); ++period) {
        beat.wait();
        for (std::size_t turn = 0; turn < subjects.size(); ++turn) {
            const std::size_t i = (turn + period) % subjects.size();
            if (const auto latency = time_one_frame(subjects[i]->lane())) {
                samples[i].push_back(*latency);
            }
        }
    }
    std::vector<LatencyResult> results;
    for (std::size_t i = 0; i < subjects.size(); ++i) {
        results.push_back(
            result_of(*subjects[i], std::move(samples[i]), used_by(*subjects[i]) - used_before[i]));
    }
    return results;
}

namespace {

/// The tester of many lanes at once.
class Driver {
  public:
    Driver(Subject& subject, const DriveSettings& settings)
        : lanes_(subject.lanes()), settings_(settings), epoll_(::epoll_create1(EPOLL_CLOEXEC)) {
        samples_.reserve(lanes_.size() * settings.rounds);
        for (std::size_t i = 0; i < lanes_.size(); ++i) {
            lanes_[i].drain();
            lanes_[i].start_counting();
            epoll_event event{};
            event.events = EPOLLIN;
            event.data.u64 = i;
            ::epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, lanes_[i].out_descriptor(), &event);
        }
    }

    std::vector<Duration> run() {
        const std::size_t at_once = settings_.at_one_instant ? lanes_.size() : 1;
        const std::uint64_t turns = settings_.rounds * lanes_.size() / at_once;
        const Duration step = settings_.period / static_cast<std::int64_t>(lanes_.size() / at_once);
        Instant next = monotonic_now() + step;
        std::size_t lane = 0;
        for (std::uint64_t turn = 0; turn < turns && !interrupted(); ++turn) {
            receive_until(next);
            const Instant now = monotonic_now();
            next = (now - next > settings_.period / 8 ? now : next) + step;
            for (std::size_t i = 0; i < at_once; ++i) {
                if (!lanes_[lane].outstanding()) {
                    lanes_[lane].send();
                }
                lane = (lane + 1) % lanes_.size();
            }
        }
        const Instant end = monotonic_now() + kLostAfter;
        while (monotonic_now() < end && std::ranges::any_of(lanes_, &Lane::outstanding)) {
            receive_until(monotonic_now() + std::chrono::milliseconds(5));
        }
        return std::move(samples_);
    }

  private:
    void receive_until(Instant end) {
        std::array<epoll_event, 64> events;
        Instant now = monotonic_now();
        do {
            const timespec timeout = as_timespec(end - now);
            const int count = ::epoll_pwait2(epoll_.get(), events.data(),
                                             static_cast<int>(events.size()), &timeout, nullptr);
            for (int i = 0; i < count; ++i) {
                receive(lanes_[events[static_cast<std::size_t>(i)].data.u64]);
            }
            now = monotonic_now();
        } while (now < end);
    }

    void receive(Lane& lane) {
        if (lane.receive()) {
            samples_.push_back(monotonic_now() - lane.sent_at());
        }
    }

    std::vector<Lane>& lanes_;
    DriveSettings settings_;
    UniqueFd epoll_;
    std::vector<Duration> samples_;
};

}  // namespace

LatencyResult drive(Subject& subject, const DriveSettings& settings) {
    const Duration used_before = used_by(subject);
    std::vector<Duration> samples = Driver(subject, settings).run();
    return result_of(subject, std::move(samples), used_by(subject) - used_before);
}

}  // namespace tribus::bench
