#include "app/doctor/listening/sbus_scale_guess.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include <fmt/format.h>

#include "pipelines/rules/settings.h"

namespace tribus::doctor {
namespace {

/// Values that senders send for a stick at its centre and ends, by scale (docs/protocols/sbus.md,
/// "Scales"). Betaflight's own ends and FrSky's lie on scales that differ by less than half a
/// microsecond.
struct Landmarks {
    std::string_view name;
    std::uint16_t low;
    std::uint16_t centre;
    std::uint16_t high;
    int centre_tolerance;
    int end_tolerance;
};
constexpr std::array<Landmarks, 5> kLandmarks{{{"betaflight", 192, 992, 1792, 1, 0},
                                               {"frsky", 172, 992, 1811, 1, 1},
                                               {"futaba", 352, 1024, 1696, 1, 0},
                                               {"px4", 202, 1002, 1802, 0, 0},
                                               {"ardupilot", 201, 1001, 1801, 0, 0}}};

bool near(std::uint16_t value, std::uint16_t landmark, int tolerance) {
    return std::abs(int{value} - int{landmark}) <= tolerance;
}

/// The default of `plausible`: a frame with a channel outside of it does not count.
constexpr PulseRange kPlausible{Pulse::from_microseconds(800), Pulse::from_microseconds(2200)};

struct Votes {
    std::size_t centres = 0;
    std::size_t ends = 0;
    std::size_t all() const { return centres + ends; }
};

}  // namespace

void ScaleWatch::take(std::span<const std::uint16_t> raw) {
    for (std::size_t channel = 0; channel < std::min(raw.size(), seen_.size()); ++channel) {
        Seen& seen = seen_[channel];
        seen.least = std::min(seen.least, raw[channel]);
        seen.most = std::max(seen.most, raw[channel]);
        seen.latest = raw[channel];
    }
    any_ = true;
}

/// A value that does not count with this scale: "channel 12 is at 739.625 us". Empty if there is
/// none.
std::string ScaleWatch::implausible_with(const SbusScale& scale) const {
    for (std::size_t channel = 0; channel < seen_.size(); ++channel) {
        for (const std::uint16_t raw : {seen_[channel].least, seen_[channel].most}) {
            const Pulse pulse = scale.decode(raw);
            if (!kPlausible.contains(pulse)) {
                return fmt::format("channel {} is at {} us", channel + 1, pulse.microseconds());
            }
        }
    }
    return "";
}

ScaleGuess ScaleWatch::guess() const {
    constexpr std::size_t kFewestVotes = 3;
    std::array<Votes, kLandmarks.size()> votes{};
    for (const Seen& seen : seen_) {
        for (std::size_t i = 0; i < kLandmarks.size() && any_; ++i) {
            const Landmarks& marks = kLandmarks[i];
            votes[i].centres += near(seen.latest, marks.centre, marks.centre_tolerance) ? 1U : 0U;
            votes[i].ends += near(seen.least, marks.low, marks.end_tolerance) ? 1U : 0U;
            votes[i].ends += near(seen.most, marks.high, marks.end_tolerance) ? 1U : 0U;
        }
    }
    std::size_t best = 0;
    std::size_t rival = 0;
    for (std::size_t i = 1; i < votes.size(); ++i) {
        best = votes[i].all() > votes[best].all() ? i : best;
    }
    for (std::size_t i = 0; i < votes.size(); ++i) {
        const bool same_line = kLandmarks[i].centre == kLandmarks[best].centre;
        rival = i != best && !same_line ? std::max(rival, votes[i].all()) : rival;
    }
    if (votes[best].all() < kFewestVotes || votes[best].all() < 2 * rival) {
        return {
            .name = {},
            .reason =
                "the scale cannot be determined from these values: move every stick to its centre "
                "and to both ends while it listens, or use that of the receiver's maker"};
    }
    const Landmarks& marks = kLandmarks[best];
    std::string reason = fmt::format("{} channels rest at {}", votes[best].centres, marks.centre);
    if (votes[best].ends > 0) {
        reason += fmt::format(", {} ends are at {} or {}", votes[best].ends, marks.low, marks.high);
    }
    const std::string implausible = implausible_with(*SbusScale::named(marks.name));
    if (!implausible.empty()) {
        return {
            .name = {},
            .reason = fmt::format(
                "{}, as in the scale \"{}\", but with it {}, and a frame with a channel outside "
                "of {} to {} us does not count: use the scale of the receiver's maker, and "
                "widen `plausible` if nothing moves by that channel",
                reason, marks.name, implausible, kPlausible.low.microseconds(),
                kPlausible.high.microseconds())};
    }
    return {.name = marks.name, .reason = std::move(reason)};
}

}  // namespace tribus::doctor
