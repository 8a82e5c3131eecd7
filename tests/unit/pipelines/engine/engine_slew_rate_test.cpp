#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/pipelines/engine/engine_bench.h"

/// How fast a channel with a limited rate of change moves in the frames of an output.
namespace tribus::test::serial::engine_slew_rate_test {
namespace {

/// What limits the rate of change of channel 1.
enum class Limit : std::uint8_t { output_map, input_map, changeover, failsafe };

struct Case {
    Limit limit = Limit::output_map;
    double us_per_second = 0;
    ScheduleSettings schedule{};
    Duration interval{};  ///< of the input's frames
    bool absent = false;  ///< the input has 14 channels, of 16 that the output needs
};

std::string words(const Case& c) {
    return "limit " + std::to_string(static_cast<int>(c.limit)) + ", " +
           std::to_string(c.us_per_second) + " us/s, period " +
           std::to_string(c.schedule.period / 1us) + " us, interval " +
           std::to_string(c.interval / 1us) + " us" + (c.absent ? ", with absent channels" : "");
}

InputSettings input_of(const Case& c) {
    InputSettings input = c.absent ? ibus_input() : sbus_input();
    if (c.limit == Limit::input_map) {
        input.channels = {
            {.output = 0, .source = FromChannel{0}, .slew_us_per_second = c.us_per_second}};
    }
    return input;
}

OutputSettings output_of(const Case& c) {
    OutputSettings output = sbus_output({0, 1}, {.hold = 0ms});
    output.schedule = c.schedule;
    output.failsafe.presets[0] = us(1000);
    switch (c.limit) {
        case Limit::output_map:
            output.channels = {
                {.output = 0, .source = FromChannel{0}, .slew_us_per_second = c.us_per_second}};
            break;
        case Limit::input_map:
            break;
        case Limit::changeover:
            output.selection.changeover_us_per_second = c.us_per_second;
            break;
        case Limit::failsafe:
            output.failsafe.slew_us_per_second = c.us_per_second;
            break;
    }
    return output;
}

/// Channel 1 has to go from 1000 to 2000 us after a second, because the stick moves, the first
/// input is lost, or the inputs begin to send. Returns how fast it did, from the first frame in
/// which it moved to the last one before its end, or in half a minute.
double measured(const Case& c) {
    constexpr double kSlow = 500;
    Bench bench(list(input_of(c), input_of(c)), list(output_of(c)));
    const auto send = [&](std::size_t input, Instant when, int first) {
        if (c.absent) {
            bench.ibus(input, when, us(first));
        } else {
            bench.sbus(input, when, us(first), false, false);
        }
    };
    const auto value = [&] {
        return bench.engine().outputs()[0].latest().channel_or(0, {}).microseconds();
    };
    const auto time = [&] {
        return std::chrono::duration<double>(bench.engine().outputs()[0].latest_due() - Instant{})
            .count();
    };
    Instant when = at(1ms);
    for (; c.limit != Limit::failsafe && when < at(1s); when += c.interval) {
        send(0, when, 1000);
        send(1, when, 2000);
    }
    when = std::max(when, at(1s));
    bench.loop().run_until(when);
    const double from = 1000;
    EXPECT_EQ(value(), from);
    double first_us = from;
    double first_s = 0;
    double last_us = from;
    double last_s = 0;
    const Instant end = when + (c.us_per_second < kSlow ? 30s : 3s);
    for (; when < end && value() < 1990; when += c.interval) {
        if (c.limit != Limit::changeover) {
            send(0, when, 2000);
        }
        send(1, when, 2000);
        bench.loop().run_until(when + c.interval);
        if (value() < 1990) {
            last_us = value();
            last_s = time();
        }
        if (first_us == from && value() != from) {
            first_us = last_us;
            first_s = last_s;
        }
    }
    return (last_us - first_us) / (last_s - first_s);
}

void expect_exact(Limit limit, bool absent) {
    constexpr double kExact = 0.01;
    for (const double rate : {1., 2., 4., 5., 10., 20., 50., 100., 300., 1000., 3000., 10'000.}) {
        for (const Duration period : {7ms, 10ms, 14ms, 20ms}) {
            for (const auto& [kind, interval] : {std::pair(ScheduleKind::grid, Duration(7700us)),
                                                 std::pair(ScheduleKind::follow, Duration(9ms))}) {
                const Case c{limit, rate, {.kind = kind, .period = period}, interval, absent};
                EXPECT_NEAR(measured(c), rate, rate * kExact) << words(c);
            }
        }
    }
}

TEST(RateOfASlew, InTheMapOfAnOutputIsExact) {
    expect_exact(Limit::output_map, false);
}

/// SBUS needs a value for channels 15 and 16, which the presets give.
TEST(RateOfASlew, InTheMapOfAnOutputIsExactBesideAbsentChannels) {
    expect_exact(Limit::output_map, true);
}

TEST(RateOfASlew, InTheMapOfAnInputIsExact) {
    expect_exact(Limit::input_map, false);
    expect_exact(Limit::input_map, true);
}

TEST(RateOfASlew, IsExactForAChangeover) {
    expect_exact(Limit::changeover, false);
    expect_exact(Limit::changeover, true);
}

TEST(RateOfASlew, BackFromPresetsIsExact) {
    expect_exact(Limit::failsafe, false);
    expect_exact(Limit::failsafe, true);
}

}  // namespace
}  // namespace tribus::test::serial::engine_slew_rate_test
