#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <memory>
#include <numbers>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "config/build/build.h"
#include "pipelines/virtual_time/virtual_loop.h"
#include "tests/sim/simulation.h"
#include "tests/sim/stored_table.h"
#include "transports/codecs/sbus/sbus.h"

/// Three receivers get the same sticks; their calibrations are 5 us apart. One of them fails in one
/// way.
namespace tribus::test::redundancy_test {
namespace {

using namespace std::chrono_literals;

constexpr Duration kReceiverPeriod = 7ms;
constexpr Duration kOutputPeriod = 7ms;
constexpr Instant kTroubleBegins = Instant(5s);
constexpr Instant kTroubleEnds = Instant(8s);
constexpr Instant kEnd = Instant(12s);
constexpr std::array<double, 3> kCalibration{-5, 0, 5};
/// Fastest movement of the stick in microseconds a second.
constexpr double kStickSpeed = 400;

double stick_at(Duration since_start) {
    const double seconds = std::chrono::duration<double>(since_start).count();
    return 1500 + 400 * std::sin(seconds * kStickSpeed / 400);
}

/// Returns what the receiver sends instead of the live frame at this time after its trouble began,
/// or nothing if it is silent. `last` is its previous frame.
using Trouble = std::function<std::optional<ChannelFrame>(Duration, const ChannelFrame& live,
                                                          const ChannelFrame& last)>;

struct NamedTrouble {
    const char* name;
    Trouble trouble;
};

const std::vector<NamedTrouble>& troubles() {
    static const std::vector<NamedTrouble> all{
        {"wire pulled", [](Duration, const ChannelFrame&,
                           const ChannelFrame&) { return std::optional<ChannelFrame>(); }},
        {"frozen", [](Duration, const ChannelFrame&,
                      const ChannelFrame& last) { return std::optional(last); }},
        {"throttle and sticks at wild values",
         [](Duration since, ChannelFrame live, const ChannelFrame&) {
             std::mt19937 random(static_cast<unsigned>(since.count()));
             for (std::size_t channel = 0; channel < 8; ++channel) {
                 live.set(channel, Pulse::from_microseconds(
                                       1000 + static_cast<std::int64_t>(random() % 1001)));
             }
             return std::optional(live);
         }},
        {"presets, failsafe flag",
         [](Duration, ChannelFrame live, const ChannelFrame&) {
             live.set(0, kCentrePulse);
             live.frame_lost = live.failsafe = true;
             return std::optional(live);
         }},
        {"frame lost for ever",
         [](Duration, const ChannelFrame&, ChannelFrame last) {
             last.frame_lost = true;
             return std::optional(last);
         }},
        {"gone for 60 ms each 300 ms",
         [](Duration since, const ChannelFrame& live, const ChannelFrame&) {
             return since % 300ms < 60ms ? std::nullopt : std::optional(live);
         }},
    };
    return all;
}

struct Mode {
    const char* name;
    const char* lines;
};
constexpr std::array kModes{
    Mode{"one receiver", ""},
    Mode{"priority", "mode = \"priority\""},
    Mode{"priority, changeover 500us/s", "mode = \"priority\"\nchangeover = \"500us/s\""},
    Mode{"sticky", "mode = \"sticky\""},
    Mode{"freshest", "mode = \"freshest\""},
    Mode{"median", "mode = \"median\""},
};

std::string job_with(const Mode& mode) {
    std::string text;
    for (const std::string name : {"a", "b", "c"}) {
        text += fmt::format("[input.{0}]\nprotocol = \"sbus\"\ndevice = \"/dev/{0}\"\n", name);
    }
    const bool one = mode.lines[0] == '\0';
    if (one) {
        text = text.substr(0, text.find("[input.b]"));
    }
    return text + fmt::format(R"([output.out]
protocol = "sbus"
device   = "/dev/out"
period   = "7ms"
schedule = "grid"
[pipeline.main]
from = {}
to   = "out"
{}
)",
                              one ? "\"a\"" : "[\"a\", \"b\", \"c\"]", mode.lines);
}

struct Met {
    Duration to_mark = Duration::max();
    Duration to_failsafe = Duration::max();
    Duration to_clean = Duration::max();
    double largest_error_us = 0;
    double largest_step_us = 0;
    Duration longest_pause{};
};

class Trio final : public StationObserver {
  public:
    Trio(const Mode& mode, std::size_t victim, const Trouble& trouble)
        : engine_(build_engine(configuration_of(job_with(mode)))) {
        VirtualLoop loop(*engine_, *this, Instant{});
        const std::size_t receivers = engine_->inputs().size();
        std::array<ChannelFrame, 3> last{};
        for (Instant beat{}; beat < kEnd; beat += kReceiverPeriod) {
            for (std::size_t i = 0; i < receivers; ++i) {
                const Instant at = beat + i * 2300us;
                const ChannelFrame live = live_frame(i, at);
                std::optional<ChannelFrame> sent = live;
                if (i == victim && at >= kTroubleBegins && at < kTroubleEnds) {
                    sent = trouble(at - kTroubleBegins, live, last[i]);
                } else {
                    last[i] = live;
                }
                if (sent) {
                    std::array<std::uint8_t, kLongestSerialFrame> wire{};
                    const std::size_t length = SbusEncoder().write(*sent, wire, Instant{});
                    loop.receive(input_station(i), std::span(wire).first(length), at);
                }
            }
        }
        loop.run_until(kEnd);
    }

    void wrote(Station /*station*/, Instant at, const Transmission& sent) override {
        const SbusFrame frame = parse_sbus(sent.bytes().first<kSbusFrameLength>());
        says_.push_back({at, 880 + frame.raw[0] * 0.625, frame.frame_lost, frame.failsafe});
    }

    Met met() const {
        Met met;
        for (std::size_t i = 1; i < says_.size(); ++i) {
            const Says& says = says_[i];
            if (says.at < kTroubleBegins - 1s) {
                continue;
            }
            note_times(says, met);
            const double error = std::abs(says.value_us - stick_at(says.at.time_since_epoch()));
            if (!says.frame_lost) {
                met.largest_error_us = std::max(met.largest_error_us, error);
            }
            met.largest_step_us =
                std::max(met.largest_step_us, std::abs(says.value_us - says_[i - 1].value_us));
            met.longest_pause = std::max(met.longest_pause, says.at - says_[i - 1].at);
        }
        return met;
    }

    /// Returns the largest difference between two frames with the same index.
    double largest_difference(const Trio& other) const {
        EXPECT_EQ(says_.size(), other.says_.size());
        double largest = 0;
        for (std::size_t i = 0; i < std::min(says_.size(), other.says_.size()); ++i) {
            largest = std::max(largest, std::abs(says_[i].value_us - other.says_[i].value_us));
        }
        return largest;
    }

  private:
    struct Says {
        Instant at;
        double value_us = 0;
        bool frame_lost = false;
        bool failsafe = false;
    };

    static ChannelFrame live_frame(std::size_t receiver, Instant at) {
        ChannelFrame frame;
        frame.frame_lost = frame.failsafe = false;
        for (std::size_t channel = 0; channel < 16; ++channel) {
            frame.set(channel, kCentrePulse);
        }
        frame.set(0, Pulse::from_fractional_microseconds(stick_at(at.time_since_epoch()) +
                                                         kCalibration[receiver]));
        return frame;
    }
    static void note_times(const Says& says, Met& met) {
        const Duration since = says.at - kTroubleBegins;
        if (says.at >= kTroubleBegins && says.frame_lost) {
            met.to_mark = std::min(met.to_mark, since);
        }
        if (says.at >= kTroubleBegins && says.failsafe) {
            met.to_failsafe = std::min(met.to_failsafe, since);
        }
        if (says.at >= kTroubleEnds) {
            const Duration clean = says.at - kTroubleEnds;
            met.to_clean = says.frame_lost ? Duration::max() : std::min(met.to_clean, clean);
        }
    }

    std::unique_ptr<Engine> engine_;
    std::vector<Says> says_;
};

std::string milliseconds(Duration duration) {
    return duration == Duration::max()
               ? "never"
               : fmt::format("{:.0f}", std::chrono::duration<double, std::milli>(duration).count());
}

TEST(Redundancy, WhatAReaderMeetsWhenTheFirstReceiverFailsIsAsStored) {
    std::string table =
        "# Three receivers hear the same stick, which moves at up to 400 us/s; they are 5 us "
        "apart\n"
        "# in calibration. The first one fails for 3 s. What a reader of the SBUS output (7 ms)\n"
        "# meets: time to the first mark, to failsafe, and from the end of the trouble to clean\n"
        "# control; the largest error of unmarked values and the largest step, and the longest\n"
        "# pause between two frames. Timeout 100 ms, hold 300 ms, recover 500 ms.\n";
    for (const auto& [name, trouble] : troubles()) {
        table += fmt::format(
            "\n{}\n  mark ms  failsafe ms  clean ms  error us  step us  pause ms\n", name);
        for (const Mode& mode : kModes) {
            const Met met = Trio(mode, 0, trouble).met();
            table += fmt::format("{:>9} {:>12} {:>9} {:9.0f} {:8.0f} {:>9}  {}\n",
                                 milliseconds(met.to_mark), milliseconds(met.to_failsafe),
                                 milliseconds(met.to_clean), met.largest_error_us,
                                 met.largest_step_us, milliseconds(met.longest_pause), mode.name);
        }
    }
    expect_stored("redundancy.txt", table);
}

TEST(Redundancy, WithAMedianNoFailureOfOneChangesAFrameByMoreThanTheirCalibration) {
    // The frames of one cycle may be up to one period of the receivers apart.
    constexpr double kMoved = kStickSpeed * 0.007;
    const double calibration = kCalibration[2] - kCalibration[0];
    const Mode& median = kModes.back();
    const Trio untroubled(median, 0, [](Duration, ChannelFrame live, const ChannelFrame&) {
        return std::optional(live);
    });
    for (std::size_t victim = 0; victim < kCalibration.size(); ++victim) {
        for (const auto& [name, trouble] : troubles()) {
            SCOPED_TRACE(fmt::format("receiver {}: {}", victim, name));
            const Trio trio(median, victim, trouble);
            const Met met = trio.met();
            EXPECT_EQ(met.to_mark, Duration::max());
            EXPECT_LE(trio.largest_difference(untroubled), calibration + kMoved);
            EXPECT_EQ(met.longest_pause, kOutputPeriod);
        }
    }
}

}  // namespace
}  // namespace tribus::test::redundancy_test
