#include "tests/bench/latency.h"

#include <sys/epoll.h>

#include <algorithm>
#include <array>
#include <utility>

#include "pipelines/realtime/clock.h"
#include "tests/bench/tester.h"
#include "transports/links/unique_fd.h"

namespace tribus::bench {
namespace {

/// A frame that takes longer is lost; far longer than any stall of a machine.
constexpr Duration kLostAfter = std::chrono::milliseconds(500);

/// The first frames come after a pause and are not typical.
constexpr std::uint64_t kFirstLatencyFrames = 20;

Duration used_by(const Subject& subject) {
    const auto usage = subject.usage();
    return usage ? usage->processor_time : Duration::zero();
}

LatencyResult result_of(const Subject& subject, std::vector<Duration> samples, Duration used) {
    LatencyResult result;
    result.lost = subject.lost();
    result.torn = subject.torn();
    if (subject.arrived() > 0) {
        result.processor_time_per_frame = used / static_cast<std::int64_t>(subject.arrived());
    }
    result.latency = Distribution(std::move(samples));
    return result;
}

/// Tests many lanes at the same time. Each lane has its own place in the period, so that a stalled
/// lane does not shift the frames of others.
class Driver {
  public:
    Driver(std::vector<Lane*> lanes, const DriveSettings& settings)
        : lanes_(std::move(lanes)),
          settings_(settings),
          epoll_(::epoll_create1(EPOLL_CLOEXEC)),
          samples_(lanes_.size()) {
        for (std::size_t i = 0; i < lanes_.size(); ++i) {
            samples_[i].reserve(static_cast<std::size_t>(settings.rounds));
            lanes_[i]->drain();
            lanes_[i]->start_counting();
            epoll_event event{};
            event.events = EPOLLIN;
            event.data.u64 = i;
            ::epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, lanes_[i]->out_descriptor(), &event);
        }
    }

    void run() {
        const std::size_t at_once = settings_.at_one_instant ? lanes_.size() : 1;
        const std::uint64_t turns = settings_.rounds * lanes_.size() / at_once;
        const Duration step = settings_.period / static_cast<std::int64_t>(lanes_.size() / at_once);
        Instant next = monotonic_now() + step;
        std::size_t lane = 0;
        for (std::uint64_t turn = 0; turn < turns && !interrupted(); ++turn) {
            receive_until(next);
            const Instant now = monotonic_now();
            // Frames closer together than a period would have to wait in the subject.
            next = (now - next > settings_.period / 8 ? now : next) + step;
            for (std::size_t i = 0; i < at_once; ++i) {
                if (lanes_[lane]->outstanding() && now - lanes_[lane]->sent_at() > kLostAfter) {
                    lanes_[lane]->give_up();
                }
                if (!lanes_[lane]->outstanding()) {
                    lanes_[lane]->send();
                }
                lane = (lane + 1) % lanes_.size();
            }
        }
        const Instant end = monotonic_now() + kLostAfter;
        while (monotonic_now() < end && std::ranges::any_of(lanes_, &Lane::outstanding)) {
            receive_until(monotonic_now() + std::chrono::milliseconds(5));
        }
    }

    std::vector<Duration> take_samples(std::size_t lane) { return std::move(samples_[lane]); }

  private:
    void receive_until(Instant end) {
        std::array<epoll_event, 64> events;
        Instant now = monotonic_now();
        do {
            const timespec timeout = as_timespec(end - now);
            const int count = ::epoll_pwait2(epoll_.get(), events.data(),
                                             static_cast<int>(events.size()), &timeout, nullptr);
            for (int i = 0; i < count; ++i) {
                const epoll_event& event = events[static_cast<std::size_t>(i)];
                receive(static_cast<std::size_t>(event.data.u64));
            }
            now = monotonic_now();
        } while (now < end);
    }

    void receive(std::size_t lane) {
        if (lanes_[lane]->receive() && lanes_[lane]->counts().sent > kFirstLatencyFrames) {
            samples_[lane].push_back(monotonic_now() - lanes_[lane]->sent_at());
        }
    }

    std::vector<Lane*> lanes_;
    DriveSettings settings_;
    UniqueFd epoll_;
    std::vector<std::vector<Duration>> samples_;
};

}  // namespace

std::vector<LatencyResult> measure_latency(std::span<Subject* const> subjects, Duration length) {
    std::vector<Lane*> lanes;
    std::vector<Duration> used_before;
    for (Subject* subject : subjects) {
        lanes.push_back(&subject->lane());
        used_before.push_back(used_by(*subject));
    }
    const auto rounds =
        static_cast<std::uint64_t>(std::max<std::int64_t>(1, length / kFramePeriod));
    Driver driver(std::move(lanes), {.rounds = rounds});
    driver.run();
    std::vector<LatencyResult> results;
    for (std::size_t i = 0; i < subjects.size(); ++i) {
        results.push_back(result_of(*subjects[i], driver.take_samples(i),
                                    used_by(*subjects[i]) - used_before[i]));
    }
    return results;
}

LatencyResult drive(Subject& subject, const DriveSettings& settings) {
    std::vector<Lane*> lanes;
    for (Lane& lane : subject.lanes()) {
        lanes.push_back(&lane);
    }
    const std::size_t count = lanes.size();
    const Duration used_before = used_by(subject);
    Driver driver(std::move(lanes), settings);
    driver.run();
    const Duration used = used_by(subject) - used_before;
    std::vector<Duration> all;
    for (std::size_t i = 0; i < count; ++i) {
        const std::vector<Duration> samples = driver.take_samples(i);
        all.insert(all.end(), samples.begin(), samples.end());
    }
    return result_of(subject, std::move(all), used);
}

}  // namespace tribus::bench
