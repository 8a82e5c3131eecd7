#pragma once

#include <optional>
#include <span>
#include <string>

namespace tribus::bench {

/// One row of the result: a measurement, beside the same without tribus.
struct Row {
    std::string what;
    std::string figure{};
    std::string anchor{};           ///< empty if there is nothing to compare with
    std::optional<double> ratio{};  ///< figure divided by anchor
    std::string reading{};          ///< the meaning in a few words
};

/// Smallest width that `draw_table` uses.
inline constexpr std::size_t kLeastTableColumns = 60;

/// A table at most `columns` wide, but at least `kLeastTableColumns`. Words that do not fit
/// continue on the next line of their column. A row with only `what` is a heading. Pure.
std::string draw_table(std::span<const Row> rows, std::size_t columns);

/// The meaning of a ratio in words. `noise` is the ratio of the anchor to itself; `peer` names the
/// anchor.
std::string reading_of(double ratio, double noise, const std::string& peer);

}  // namespace tribus::bench
