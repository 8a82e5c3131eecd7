#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "tests/sim/simulation.h"
#include "tests/sim/stored_table.h"

namespace tribus::test::behaviour_test {
namespace {

using namespace std::chrono_literals;

constexpr Instant kInputEnds = Instant(30s);
constexpr Instant kEnd = Instant(32s);

double milliseconds(Duration duration) {
    return std::chrono::duration<double, std::milli>(duration).count();
}

double percentile(std::vector<Duration> ages, std::size_t percent) {
    std::sort(ages.begin(), ages.end());
    return ages.empty() ? 0 : milliseconds(ages[(ages.size() - 1) * percent / 100]);
}

/// Returns one row of the table: the age of good frames and the time until failsafe at one output.
std::string row(const std::string& output, Duration input_period, double loss, Duration jitter) {
    constexpr std::uint64_t kSeed = 2026;
    Simulation simulation(configuration_of(main_job(output)),
                          {Sender{.period = input_period,
                                  .last = kInputEnds,
                                  .faults = {.drop_frame = loss, .most_delay = jitter}}},
                          kSeed);
    simulation.run_until(kEnd);
    std::vector<Duration> ages;
    Instant last_arrival{};
    Instant frame_lost_at = kNever;
    Instant failsafe_at = kNever;
    for (std::uint32_t number = 0; number < simulation.frames_sent(0); ++number) {
        last_arrival = std::max(last_arrival, simulation.arrived_at(0, number).value_or(Instant{}));
    }
    for (const Written& written : simulation.written()) {
        if (written.frame.good()) {
            ages.push_back(written.at - *simulation.arrived_at(0, *written.number));
        } else if (written.at > last_arrival) {
            frame_lost_at = std::min(frame_lost_at, written.at);
            failsafe_at = written.frame.failsafe ? std::min(failsafe_at, written.at) : failsafe_at;
        }
    }
    return fmt::format("{:7.1f} {:5.0f} {:7.1f} {:7} {:8.3f} {:8.3f} {:8.3f} {:10.1f} {:10.1f}\n",
                       milliseconds(input_period), 100 * loss, milliseconds(jitter), ages.size(),
                       percentile(ages, 50), percentile(ages, 99), percentile(ages, 100),
                       milliseconds(frame_lost_at - last_arrival),
                       milliseconds(failsafe_at - last_arrival));
}

std::string table() {
    struct Kind {
        const char* title;
        const char* output;
    };
    constexpr std::array kKinds{
        Kind{"follow, period 7 ms", "period = \"7ms\""},
        Kind{"grid, period 14 ms", "period = \"14ms\"\nschedule = \"grid\""},
        Kind{"grid, period 14 ms, phase locked",
             "period = \"14ms\"\nschedule = \"grid\"\nphase = \"locked\""},
    };
    std::string text =
        "# What a reader of the SBUS output meets when i.Bus frames are lost and late. Ages are "
        "of\n"
        "# the values in frames under control, from the arrival of their last byte; the last two\n"
        "# columns count from the last frame before the input ends (timeout 100 ms, hold 300 "
        "ms).\n";
    for (const Kind& kind : kKinds) {
        text += fmt::format(
            "\n{}\n  in ms  loss%  late ms  frames  age p50      p99     most frame lost   "
            "failsafe\n",
            kind.title);
        for (const Duration period : {Duration(4ms), Duration(7700us)}) {
            for (const double loss : {0.0, 0.05, 0.3}) {
                for (const Duration jitter : {Duration(0), Duration(2ms)}) {
                    text += row(kind.output, period, loss, jitter);
                }
            }
        }
    }
    return text;
}

TEST(Behaviour, LossAndJitterToAgeAndFailsafeDelayAreAsStored) {
    expect_stored("behaviour.txt", table());
}

}  // namespace
}  // namespace tribus::test::behaviour_test
