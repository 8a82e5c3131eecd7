#include <string>
#include <vector>

#include <fmt/format.h>

#include "core/distribution.h"
#include "tests/bench/bound.h"
#include "tests/bench/response_times.h"
#include "tests/bench/tester.h"

namespace tribus::test {
namespace {

using namespace bench;

double in_milliseconds(Duration duration) {
    return static_cast<double>(duration.count()) / 1e6;
}

std::string figures_of(const Responses& responses) {
    const Distribution& times = responses.times;
    const auto microseconds = [&](double percent) {
        return times.percentile(percent).count() / 1000;
    };
    return fmt::format("p50 {} p99 {} p99.9 {} max {} us, {} of {} missing", microseconds(50),
                       microseconds(99), microseconds(99.9), microseconds(100), responses.missed,
                       times.size());
}

Figure window_figure(const std::string& row, const Responses& responses) {
    return {.row = row,
            .value = in_milliseconds(responses.times.percentile(99.9)),
            .bound = in_milliseconds(kResponseWindow),
            .note = figures_of(responses)};
}

Figure beside_bare(const std::string& row, double percent, Duration mine,
                   const ResponseTimes& times) {
    constexpr double kBound = 1.10;
    return ratio_figure(fmt::format("{}, p{}", row, percent), kBound, mine,
                        times.bare.times.percentile(percent),
                        times.bare_again.times.percentile(percent));
}

Figures response_figures(const BoundSettings& settings) {
    const auto times = response_times(settings);
    if (!times) {
        return Refused(times.error());
    }
    std::vector<Figure> figures{
        window_figure("response at once, p99.9, ms", times->at_once),
        window_figure("response by default, p99.9, ms", times->by_default),
        window_figure("response of the bare responder, p99.9, ms", times->bare)};
    for (const double percent : {50.0, 99.0, 99.9}) {
        figures.push_back(beside_bare("response at once / bare responder", percent,
                                      times->at_once.times.percentile(percent), *times));
    }
    for (const double percent : {50.0, 99.0, 99.9}) {
        figures.push_back(
            beside_bare("default less its 200 us / bare", percent,
                        times->by_default.times.percentile(percent) - kDefaultReplyAfter, *times));
    }
    return figures;
}

}  // namespace

std::vector<Bound> response_bounds() {
    return {
        {"response", "answers of a sensor bus beside a bare responder", true, response_figures}};
}

}  // namespace tribus::test
