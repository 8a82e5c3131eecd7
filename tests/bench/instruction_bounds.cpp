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

/// A row of the table for each of `rows`, with the bound of the same place: the count on x86. The
/// note of a codec has that on ARM.
template <std::size_t count>
Figures counted_rows(const std::array<Row, count>& rows,
                     const std::array<std::pair<const char*, double>, count>& bounds) {
    if (const std::string what = missing(Machine::x86); !what.empty()) {
        return Refused(what);
    }
    std::vector<Figure> figures;
    for (std::size_t i = 0; i < count; ++i) {
        const auto x86 = cost(Machine::x86, rows[i]);
        if (!x86) {
            return Refused(fmt::format("{}: the count went wrong", rows[i].name));
        }
        figures.push_back({.row = bounds[i].first, .value = *x86, .bound = bounds[i].second});
        if (rows[i].counted == Counted::codecs) {
            const std::string what = missing(Machine::arm);
            const auto arm = what.empty() ? cost(Machine::arm, rows[i]) : std::nullopt;
            figures.back().note = arm ? fmt::format("Cortex-A72: {:.0f}", *arm) : what;
        }
    }
    return figures;
}

Figures codecs(const BoundSettings& /*settings*/) {
    constexpr std::array<std::pair<const char*, double>, kFrameRows.size()> kBounds{{
        {"instructions, decode SBUS, one read", 130},
        {"instructions, decode i.Bus, one read", 170},
        {"instructions, decode SBUS, byte by byte", 450},
        {"instructions, decode i.Bus, byte by byte", 600},
        {"instructions, encode SBUS", 80},
        {"instructions, encode i.Bus", 65},
        {"instructions, encode SBUS, absent channels", 120},
        {"instructions, decode CRSF, one read", 140},
        {"instructions, decode CRSF, byte by byte", kNoBound},
        {"instructions, encode CRSF", 90},
        {"instructions, decode GHST, one read", 140},
        {"instructions, decode GHST, byte by byte", kNoBound},
        {"instructions, encode GHST", 140},
        {"instructions, decode SRXL, one read", 350},
        {"instructions, decode SRXL, byte by byte", kNoBound},
        {"instructions, encode SRXL", 350},
        {"instructions, decode F.Port 2, one read", 270},
        {"instructions, decode F.Port, one read", 290},
        {"instructions, decode i-BUS2, one read", 290},
        {"instructions, decode DSM, one read", 160},
        {"instructions, decode EX Bus, one read", 400},
    }};
    return counted_rows(kFrameRows, kBounds);
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

Figures engine(const BoundSettings& /*settings*/) {
    constexpr std::array<std::pair<const char*, double>, kEngineRows.size()> kBounds{{
        {"instructions, core pipeline, 18 channels", 300},
        {"instructions, core pipeline, 14 channels", 330},
        {"instructions, engine, 18 channels", kNoBound},
        {"instructions, engine, 14 channels", kNoBound},
        {"instructions, engine, 18 channels, map", kNoBound},
        {"instructions, engine, 14 channels, map", kNoBound},
        {"instructions, engine, SBUS to i.Bus", kNoBound},
        {"instructions, engine, native CAN to SBUS", kNoBound},
        {"instructions, engine, i.Bus to native CAN", kNoBound},
        {"instructions, engine, DroneCAN to SBUS", kNoBound},
        {"instructions, engine, i.Bus to DroneCAN", kNoBound},
    }};
    return counted_rows(kEngineRows, kBounds);
}

Figures link(const BoundSettings& /*settings*/) {
    constexpr std::array<std::pair<const char*, double>, kLinkRows.size()> kBounds{{
        {"instructions, CAN snapshot out, echo", 2500},
        {"instructions, CAN snapshot out, no echo", 2500},
        {"instructions, CAN snapshot in", kNoBound},
    }};
    auto figures = counted_rows(kLinkRows, kBounds);
    for (const Row& row : kLinkRows) {
        const auto calls = system_calls(row);
        if (!figures || !calls) {
            return figures ? Refused(fmt::format("{}: the count went wrong", row.name)) : figures;
        }
        figures->push_back({.row = fmt::format("system calls, {}", row.name),
                            .value = *calls,
                            .bound = row.workload == "out_with_echo"      ? 4
                                     : row.workload == "out_without_echo" ? 6
                                                                          : kNoBound});
    }
    return figures;
}

Figures daemon(const BoundSettings& /*settings*/) {
    constexpr std::array<std::pair<const char*, double>, kDaemonRows.size()> kBounds{{
        {"instructions a frame, daemon, 18 channels", 1000},
        {"instructions a frame, daemon, 14 channels", 1050},
        {"instructions a frame, daemon, SBUS to i.Bus", kNoBound},
    }};
    std::vector<Figure> figures;
    for (std::size_t i = 0; i < kDaemonRows.size(); ++i) {
        const auto counted = daemon_instructions(kDaemonRows[i].carries);
        if (!counted) {
            return Refused(counted.error());
        }
        figures.push_back({.row = kBounds[i].first,
                           .value = counted->a_frame,
                           .bound = kBounds[i].second,
                           .note = fmt::format("all threads, through rules; main thread {:.0f} a "
                                               "second",
                                               counted->a_second_of_main_thread)});
    }
    return figures;
}

}  // namespace

std::vector<Bound> instruction_bounds() {
    return {
        {"codecs", "instructions a frame, by callgrind and an emulated ARM", false, codecs},
        {"garbage", "instructions a byte of adversarial garbage", false, garbage},
        {"engine", "instructions a frame from arrival to sending", false, engine},
        {"link", "instructions and system calls of a CAN snapshot", false, link},
        {"daemon", "user instructions a frame of the whole program", false, daemon},
    };
}

}  // namespace tribus::test
