#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "tests/bench/bound.h"
#include "tests/bench/codec_counts.h"
#include "tests/bench/daemon_counts.h"

namespace tribus::test {
namespace {

using namespace bench;

/// Counts on x86. The note has the count on ARM.
tl::expected<Figure, std::string> counted(const Row& row, const std::string& text, double bound) {
    const auto x86 = cost(Machine::x86, row);
    if (!x86) {
        return Refused(fmt::format("{}: the count went wrong", row.name));
    }
    const auto arm = missing(Machine::arm).empty() ? cost(Machine::arm, row) : std::nullopt;
    return Figure{.row = text,
                  .value = *x86,
                  .bound = bound,
                  .note = arm ? fmt::format("Cortex-A72: {:.0f}", *arm) : missing(Machine::arm)};
}

Figures codecs(const BoundSettings& /*settings*/) {
    if (const std::string what = missing(Machine::x86); !what.empty()) {
        return Refused(what);
    }
    constexpr std::array<std::pair<const char*, double>, kFrameRows.size()> kBounds{{
        {"instructions, decode SBUS, one read", 130},
        {"instructions, decode i.Bus, one read", 170},
        {"instructions, decode SBUS, byte by byte", 450},
        {"instructions, decode i.Bus, byte by byte", 600},
        {"instructions, encode SBUS", 80},
        {"instructions, encode i.Bus", 65},
        {"instructions, encode SBUS, absent channels", 120},
    }};
    std::vector<Figure> figures;
    for (std::size_t i = 0; i < kBounds.size(); ++i) {
        auto figure = counted(kFrameRows[i], kBounds[i].first, kBounds[i].second);
        if (!figure) {
            return Refused(figure.error());
        }
        figures.push_back(std::move(*figure));
    }
    return figures;
}

/// Returns the worst of all streams. The note has the number of streams beyond the bound.
Figures garbage(const BoundSettings& /*settings*/) {
    constexpr double kBound = 110;
    if (const std::string what = missing(Machine::x86); !what.empty()) {
        return Refused(what);
    }
    Figure worst{.row = "instructions a byte of garbage, the worst", .bound = kBound};
    std::string beyond;
    for (const Row& row : kGarbageRows) {
        const auto instructions = cost(Machine::x86, row);
        if (!instructions) {
            return Refused(fmt::format("{}: the count went wrong", row.name));
        }
        worst.value = std::max(worst.value, *instructions);
        if (*instructions > kBound) {
            beyond +=
                fmt::format("{}{} {:.0f}", beyond.empty() ? "" : ", ", row.name, *instructions);
        }
    }
    worst.note = beyond.empty() ? "all streams of codec_ceilings.h" : "beyond: " + beyond;
    return std::vector{worst};
}

Figures daemon(const BoundSettings& /*settings*/) {
    const auto cost = instructions_a_frame();
    if (!cost) {
        return Refused(cost.error());
    }
    return std::vector<Figure>{{.row = "instructions a frame of the whole daemon",
                                .value = *cost,
                                .bound = 1000,
                                .note = "all threads; i.Bus, 18 channels through rules, SBUS"}};
}

}  // namespace

std::vector<Bound> instruction_bounds() {
    return {
        {"codecs", "instructions a frame, by callgrind and an emulated ARM", false, codecs},
        {"garbage", "instructions a byte of adversarial garbage", false, garbage},
        {"daemon", "user instructions a frame of the whole program", false, daemon},
    };
}

}  // namespace tribus::test
