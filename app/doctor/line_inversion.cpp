#include "app/doctor/line_inversion.h"

#include <algorithm>
#include <array>
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

struct HeardByte {
    Duration at{};
    std::uint8_t value = 0;
    bool damaged = false;

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
            found.push_back(bytes[i]);
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

enum class Stop : std::uint8_t { missing, there, either };

/// Looks for frames whose first byte, received inverted, is one of `headers`.
std::optional<Inversion> by_headers(const Heard& heard, std::span<const std::uint8_t> headers,
                                    Stop stop) {
    const std::vector<HeardByte> bytes = bytes_of(heard);
    const bool errors_told = std::ranges::any_of(bytes, &HeardByte::damaged);
    if (errors_told && !may_idle_low(bytes)) {
        return std::nullopt;
    }
    std::vector<Duration> times;
    for (const HeardByte& byte : first_bytes(bytes, errors_told)) {
        const bool stop_fits =
            !errors_told || stop == Stop::either || byte.damaged == (stop == Stop::missing);
        if (stop_fits && std::ranges::find(headers, byte.value) != headers.end()) {
            times.push_back(byte.at);
        }
    }
    const auto period = regular_period(times);
    return period ? std::optional(Inversion{.period = period}) : std::nullopt;
}

}  // namespace

std::optional<Inversion> inverted_sbus(const Heard& heard) {
    constexpr std::array<std::uint8_t, 1> kHeader{0xF8};
    return by_headers(heard, kHeader, Stop::missing);
}

std::optional<Inversion> inverted_ibus(const Heard& heard) {
    constexpr std::array<std::uint8_t, 2> kHeaders{0xF3, 0xFB};
    return by_headers(heard, kHeaders, Stop::there);
}

std::optional<Inversion> inverted_sensor_bus(const Heard& heard) {
    constexpr std::array<std::uint8_t, 1> kLength{0x9F};
    return by_headers(heard, kLength, Stop::either);
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
