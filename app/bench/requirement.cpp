#include "app/bench/requirement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "core/quantity.h"

namespace tribus::bench {
namespace {

constexpr std::string_view kAdded = "added-";
constexpr std::array<std::pair<std::string_view, double>, 3> kPercentiles{
    {{"p50", 50}, {"p90", 90}, {"p99", 99}}};

std::optional<double> percent_of(std::string_view name) {
    for (const auto& [known, percent] : kPercentiles) {
        if (name == known) {
            return percent;
        }
    }
    return std::nullopt;
}

}  // namespace

tl::expected<Requirement, std::string> parse_requirement(std::string_view text) {
    const auto refuse = [&](std::string_view what) {
        return tl::unexpected(fmt::format(
            "--require {}: {}; allowed: p50, p90 or p99, or the same with added- in front, then = "
            "and a time in us, ms or s, such as p99=200us or added-p50=20us",
            text, what));
    };
    const std::size_t equals = text.find('=');
    if (equals == std::string_view::npos) {
        return refuse("there is no =");
    }
    Requirement requirement;
    requirement.text = text;
    std::string_view name = text.substr(0, equals);
    if (name.starts_with(kAdded)) {
        requirement.added = true;
        name.remove_prefix(kAdded.size());
    }
    const auto percent = percent_of(name);
    if (!percent) {
        return refuse(fmt::format("\"{}\" is not a known percentile", name));
    }
    const auto most = parse_duration(text.substr(equals + 1));
    if (!most) {
        return refuse(fmt::format("\"{}\" is not a time", text.substr(equals + 1)));
    }
    requirement.percent = *percent;
    requirement.most = *most;
    return requirement;
}

std::optional<std::string> broken(const Requirement& requirement, Duration whole, Duration bare) {
    const Duration measured = requirement.added ? whole - bare : whole;
    if (measured <= requirement.most) {
        return std::nullopt;
    }
    return fmt::format("{} does not hold: the {}latency's p{:.0f} was {}", requirement.text,
                       requirement.added ? "added " : "", requirement.percent,
                       short_time(measured));
}

std::string short_time(Duration duration) {
    constexpr std::array<std::pair<double, std::string_view>, 4> kUnits{
        {{1e9, "s"}, {1e6, "ms"}, {1e3, "us"}, {1, "ns"}}};
    constexpr int kDigits = 3;
    const auto count = static_cast<double>(duration.count());
    for (const auto& [size, unit] : kUnits) {
        const double value = count / size;
        // A value that rounds up to the next larger unit is written in that unit.
        if (std::abs(value) >= 0.9995 || size == 1) {
            const double digits = std::floor(std::log10(std::max(std::abs(value), 1.0))) + 1;
            const int decimals = size == 1 ? 0 : std::max(0, kDigits - static_cast<int>(digits));
            return fmt::format("{:.{}f}{}", value, decimals, unit);
        }
    }
    return "0ns";
}

}  // namespace tribus::bench
