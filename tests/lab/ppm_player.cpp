#include "tests/lab/ppm_player.h"

#include <fcntl.h>
#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <ctime>
#include <string_view>

#include <gtest/gtest.h>

namespace tribus::test {
namespace {

constexpr std::uint64_t kNanosecondsPerSecond = 1'000'000'000;
constexpr std::uint64_t kPulseNanoseconds = 300'000;

std::uint64_t monotonic_ns() {
    timespec now{};
    ::clock_gettime(CLOCK_MONOTONIC, &now);
    return static_cast<std::uint64_t>(now.tv_sec) * kNanosecondsPerSecond +
           static_cast<std::uint64_t>(now.tv_nsec);
}

void sleep_until(std::uint64_t at_ns) {
    const timespec at{.tv_sec = static_cast<time_t>(at_ns / kNanosecondsPerSecond),
                      .tv_nsec = static_cast<long>(at_ns % kNanosecondsPerSecond)};
    ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, nullptr);
}

/// Lets the calling thread go first as long as it lives.
class GoesFirst {
  public:
    GoesFirst() {
        const sched_param first{.sched_priority = 98};
        ::sched_setscheduler(0, SCHED_FIFO, &first);
    }
    GoesFirst(const GoesFirst&) = delete;
    GoesFirst& operator=(const GoesFirst&) = delete;
    ~GoesFirst() {
        const sched_param usual{};
        ::sched_setscheduler(0, SCHED_OTHER, &usual);
    }
};

std::uint64_t nanoseconds(double microseconds) {
    return static_cast<std::uint64_t>(microseconds * 1000);
}

}  // namespace

PpmPlayer::PpmPlayer(const GpioBank& bank, unsigned line)
    : pull_(::open(bank.pull_file(line).c_str(), O_WRONLY | O_CLOEXEC)) {
    EXPECT_TRUE(pull_.valid());
}

PpmPlayer::Moment PpmPlayer::pulse_at(std::uint64_t at_ns) {
    const auto pull = [this](std::string_view way) {
        EXPECT_EQ(::pwrite(pull_.get(), way.data(), way.size(), 0),
                  static_cast<ssize_t>(way.size()));
    };
    sleep_until(at_ns);
    Moment moment{.before_ns = monotonic_ns()};
    pull("pull-up");
    moment.after_ns = monotonic_ns();
    sleep_until(at_ns + kPulseNanoseconds);
    pull("pull-down");
    return moment;
}

PlayedFrame PpmPlayer::play(const std::vector<double>& channels_us, double gap_us) {
    const GoesFirst first;
    PlayedFrame frame;
    std::uint64_t at_ns = std::max(latest_ns_ + nanoseconds(gap_us), monotonic_ns() + 100'000);
    Moment before = pulse_at(at_ns);
    for (const double channel : channels_us) {
        at_ns += nanoseconds(channel);
        const Moment edge = pulse_at(at_ns);
        frame.push_back({static_cast<double>(edge.before_ns - before.after_ns) / 1000,
                         static_cast<double>(edge.after_ns - before.before_ns) / 1000});
        before = edge;
    }
    latest_ns_ = at_ns;
    return frame;
}

void PpmPlayer::play_noise(int count, double distance_us) {
    const GoesFirst first;
    std::uint64_t at_ns = monotonic_ns();
    for (int pulse = 0; pulse < count; ++pulse) {
        at_ns += nanoseconds(distance_us);
        pulse_at(at_ns);
    }
    latest_ns_ = at_ns;
}

}  // namespace tribus::test
