#include <fmt/format.h>

#include "tests/bench/bound.h"
#include "tests/bench/ppm.h"

namespace tribus::test {
namespace {

Figures ppm_at_rest(const BoundSettings& settings) {
    const auto result = bench::measure_ppm(settings.line, settings.length);
    if (!result) {
        return Refused(result.error());
    }
    std::vector<Figure> figures;
    for (const double percent : {50.0, 90.0, 99.0}) {
        figures.push_back(
            {.row = fmt::format("PPM at rest, pulse from its middle, p{:.0f}, us", percent),
             .value = static_cast<double>(result->stamped.percentile(percent).count()) / 1e3,
             .bound = kNoBound,
             .note = fmt::format("a reader's clock: {}; {} channels, {} frames, {} refused",
                                 microseconds(result->bare.percentile(percent)), result->channels,
                                 result->frames, result->refused)});
    }
    return figures;
}

}  // namespace

std::vector<Bound> ppm_bounds() {
    return {{"ppm", "how far pulses are from the middle of their channel", true, ppm_at_rest}};
}

}  // namespace tribus::test
