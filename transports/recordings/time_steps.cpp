#include "transports/recordings/time_steps.h"

#include <array>
#include <chrono>
#include <cmath>

#include "transports/recordings/text.h"

namespace tribus {
namespace {

/// Digits of seconds that candump writes unless the times count from 1970.
constexpr std::size_t kShortDigits = 3;
/// Enough to see whether the times rise: the kernel may change the order of some frames.
constexpr std::size_t kEnoughLines = 16;
/// A difference of two frames needs a line before them, and one that does not rise further.
constexpr std::size_t kFewestLines = 3;
/// Equal differences need some more: frames of one instant are usual.
constexpr std::size_t kFewestEqualLines = 6;

struct Unit {
    std::string_view name;
    double seconds;
};

/// `2.5 hours`, `54.3 years`.
std::string long_duration(Duration duration) {
    constexpr std::array kUnits{Unit{"years", 365.25 * 86400}, Unit{"days", 86400},
                                Unit{"hours", 3600}};
    const double seconds = std::chrono::duration<double>(duration).count();
    for (const Unit& unit : kUnits) {
        if (seconds >= 2 * unit.seconds || unit.seconds == kUnits.back().seconds) {
            const auto tenths = static_cast<long long>(std::floor(seconds / unit.seconds * 10));
            return std::to_string(tenths / 10) + "." + std::to_string(tenths % 10) + " " +
                   std::string(unit.name);
        }
    }
    return {};
}

}  // namespace

void DifferenceWatch::take(std::size_t digits, Duration time) {
    possible_ = lines_ == 0 ? digits == kShortDigits : possible_;
    if (++lines_ > 2) {
        (time > latest_ ? up_ : down_) += std::chrono::abs(time - latest_);
    }
    latest_ = time;
}

bool DifferenceWatch::certain() const {
    return lines_ >= kEnoughLines && probable();
}

bool DifferenceWatch::probable() const {
    const bool falls = lines_ >= kFewestLines && down_ > Duration::zero() && down_ * 2 > up_;
    const bool stands = lines_ >= kFewestEqualLines && latest_ > Duration::zero() &&
                        up_ == Duration::zero() && down_ == Duration::zero();
    return possible_ && (falls || stands);
}

void GapWatch::take(Duration at, unsigned line) {
    std::optional<TimeGap>& gap = latest_ ? first_ : late_start_;
    const Duration before = latest_.value_or(Duration::zero());
    if (!gap && at - before > kLongestGap) {
        gap = TimeGap{.line = line, .from = before, .to = at};
    }
    latest_ = at;
}

std::string gap_text(std::string_view file, const TimeGap& gap) {
    return recording_text::mistake_at(
               file, gap.line, 1,
               "the times jump by " + long_duration(gap.to - gap.from) +
                   " here, and all of that would be played; make two recordings of it, of the "
                   "lines above and from this one on")
        .value();
}

std::string late_start_text(std::string_view file, const TimeGap& gap) {
    return recording_text::mistake_at(file, gap.line, 1,
                                      "the first line is " + long_duration(gap.to) +
                                          " after the start of the recording, and all of that "
                                          "would be played; subtract its time from each time")
        .value();
}

}  // namespace tribus
