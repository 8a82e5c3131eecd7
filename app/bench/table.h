#pragma once

#include <optional>
#include <span>
#include <string>

namespace tribus::bench {

/// One line of the result: what was measured, beside the same without the appliance.
struct Row {
    std::string what;
    std::string figure{};
    std::string anchor{};           ///< empty where there is nothing to compare with
    std::optional<double> ratio{};  ///< figure over anchor
    std::string reading{};          ///< in a few words
};

/// The least that `draw_table` keeps to.
inline constexpr std::size_t kLeastTableColumns = 60;

/// A table no wider than `columns`, at least `kLeastTableColumns`: words that do not fit go on in
/// the next line of their column. A row with nothing but `what` is a heading. Pure.
std::string draw_table(std::span<const Row> rows, std::size_t columns);

/// What a ratio means: `noise` is that of the anchor to itself. `peer` names the anchor.
std::string reading_of(double ratio, double noise, const std::string& peer);

}  // namespace tribus::bench
