#include "app/doctor/listening/line_inversion.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace tribus::doctor {
namespace {

using std::chrono::milliseconds;

/// Gap between reads from which a line counts as silent; adapters deliver once a millisecond.
constexpr Duration kSilence = milliseconds(2);
/// Range of the frame periods of known receivers (docs/protocols/ibus.md, "Period and gaps", and
/// docs/protocols/sbus.md, "Periods"), with the jitter of USB.
constexpr Duration kShortestPeriod = milliseconds(3);
constexpr Duration kLongestPeriod = milliseconds(110);
constexpr Duration kUneven = milliseconds(2);
/// Few enough for the slowest sender, too many for a coincidence.
constexpr std::size_t kFewestFrames = 4;

/// Gap between reads that shows the beginning of a frame, even if it comes before a break.
constexpr Duration kGap = milliseconds(1);

struct HeardByte {
    Duration at{};
    std::uint8_t value = 0;
    bool damaged = false;
    bool behind_gap = false;

    bool is_break() const { return damaged && value == 0; }
};

std::vector<HeardByte> bytes_of(const Heard& heard) {
    std::vector<HeardByte> bytes;
    for (const Burst& burst : heard.bursts) {
        for (std::size_t i = 0; i < burst.bytes.size(); ++i) {
            bytes.push_back({burst.start.value_or(Duration::zero()), burst.bytes[i],
                             i < burst.damaged.size() && burst.damaged[i]});
        }
    }
    return bytes;
}

/// True if the bytes before silences are cut off by a low line: they have no stop bit. Also true if
/// there are no silences.
bool may_idle_low(const std::vector<HeardByte>& bytes) {
    std::size_t silences = 0;
    std::size_t cut_off = 0;
    for (std::size_t i = 1; i < bytes.size(); ++i) {
        if (bytes[i].at - bytes[i - 1].at >= kSilence) {
            ++silences;
            cut_off += bytes[i - 1].damaged ? 1U : 0U;
        }
    }
    return 5 * cut_off >= 4 * silences;
}

/// The bytes with which frames begin if the line idles low. Some adapters report no errors; then
/// only silences separate frames.
std::vector<HeardByte> first_bytes(const std::vector<HeardByte>& bytes, bool errors_told) {
    std::vector<HeardByte> found;
    for (std::size_t i = 1; i < bytes.size(); ++i) {
        const bool first = errors_told ? bytes[i - 1].damaged && !bytes[i].is_break()
                                       : bytes[i].at - bytes[i - 1].at >= kSilence;
        if (first) {
            HeardByte byte = bytes[i];
            byte.behind_gap = byte.at - bytes[i - 1].at >= kGap ||
                              (i > 1 && bytes[i - 1].at - bytes[i - 2].at >= kGap);
            found.push_back(byte);
        }
    }
    return found;
}

/// The period of these times; nothing if they are not regular.
std::optional<Duration> regular_period(const std::vector<Duration>& times) {
    if (times.size() < kFewestFrames) {
        return std::nullopt;
    }
    std::vector<Duration> steps;
    for (std::size_t i = 1; i < times.size(); ++i) {
        steps.push_back(times[i] - times[i - 1]);
    }
    std::ranges::sort(steps);
    const Duration median = steps[steps.size() / 2];
    Duration sum{};
    std::size_t even = 0;
    for (const Duration step : steps) {
        if (std::chrono::abs(step - median) <= kUneven) {
            sum += step;
            ++even;
        }
    }
    const bool regular = 10 * even >= 7 * steps.size();
    if (!regular || median < kShortestPeriod || median > kLongestPeriod) {
        return std::nullopt;
    }
    return sum / static_cast<std::int64_t>(even);
}

/// A byte as a port sees it on an inverted line.
struct SeenByte {
    std::uint8_t value = 0;
    /// Its parity and stop bits are wrong. Absent: that depends on unknown bytes.
    std::optional<bool> damaged{};
};

/// The levels of a line on which a frame begins, in bit times from the first start bit, as an
/// inverted line has them. Shorter than a byte that is not known.
std::vector<bool> inverted_levels(const FrameBeginning& beginning, const LineSettings& line,
                                  unsigned pause_bits) {
    std::vector<bool> levels;
    const auto send = [&](std::uint8_t byte) {
        levels.push_back(true);
        for (unsigned bit = 0; bit < 8; ++bit) {
            levels.push_back((byte >> bit & 1U) == 0);
        }
        if (line.parity == Parity::even) {
            levels.push_back(std::popcount(byte) % 2 == 0);
        }
        levels.insert(levels.end(), line.stop_bits + pause_bits, false);
    };
    send(beginning.first);
    if (beginning.second) {
        send(*beginning.second);
    } else {
        levels.push_back(true);
    }
    return levels;
}

/// The first byte that a port sees: behind the first falling edge. Nothing if it needs bytes that
/// are not known.
std::optional<SeenByte> first_seen(const std::vector<bool>& levels, const LineSettings& line) {
    const auto fall = std::ranges::adjacent_find(
        levels, [](bool before, bool after) { return before && !after; });
    const auto data = static_cast<std::size_t>(fall - levels.begin()) + 2;
    if (fall == levels.end() || data + 8 > levels.size()) {
        return std::nullopt;
    }
    SeenByte seen;
    for (std::size_t bit = 0; bit < 8; ++bit) {
        seen.value = static_cast<std::uint8_t>(seen.value | (levels[data + bit] ? 1U << bit : 0U));
    }
    const bool has_parity = line.parity == Parity::even;
    const std::size_t stop = data + 8 + (has_parity ? 1 : 0);
    if (stop < levels.size()) {
        const bool odd = std::popcount(seen.value) % 2 != 0;
        seen.damaged = !levels[stop] || (has_parity && levels[stop - 1] != odd);
    }
    return seen;
}

std::vector<SeenByte> seen_beginnings(const Protocol& protocol, const LineSettings& line) {
    constexpr unsigned kMostPauseBits = 1;
    std::vector<SeenByte> all;
    for (const FrameBeginning& beginning : protocol.beginnings) {
        for (unsigned pause = 0; pause <= kMostPauseBits; ++pause) {
            if (const auto seen = first_seen(inverted_levels(beginning, line, pause), line)) {
                all.push_back(*seen);
            }
        }
    }
    return all;
}

}  // namespace

std::optional<Inversion> inverted_frames(const Heard& heard, const Protocol& protocol) {
    const std::vector<HeardByte> bytes = bytes_of(heard);
    const bool errors_told = std::ranges::any_of(bytes, &HeardByte::damaged);
    if (errors_told && !may_idle_low(bytes)) {
        return std::nullopt;
    }
    const std::vector<SeenByte> seen = seen_beginnings(protocol, heard.line);
    std::vector<Duration> times;
    std::size_t behind_gaps = 0;
    for (const HeardByte& byte : first_bytes(bytes, errors_told)) {
        if (std::ranges::any_of(seen, [&](const SeenByte& one) {
                return one.value == byte.value &&
                       (!errors_told || one.damaged.value_or(byte.damaged) == byte.damaged);
            })) {
            times.push_back(byte.at);
            behind_gaps += byte.behind_gap ? 1 : 0;
        }
    }
    const auto period = regular_period(times);
    return period ? std::optional(Inversion{.period = period, .behind_gaps = behind_gaps})
                  : std::nullopt;
}

std::optional<Duration> period_of_breaks(const Heard& heard) {
    std::vector<Duration> times;
    std::optional<Duration> before;
    for (const Burst& burst : heard.bursts) {
        const Duration at = burst.start.value_or(Duration::zero());
        if (!before || at - *before >= kSilence) {
            times.push_back(at);
        }
        before = at;
    }
    return regular_period(times);
}

}  // namespace tribus::doctor
