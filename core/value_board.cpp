#include "core/value_board.h"

#include <algorithm>

namespace tribus {

std::optional<std::size_t> ValueBoard::find(std::string_view name) const {
    const auto found = std::ranges::find(values_, name, &NamedValue::name);
    if (found == values_.end()) {
        return std::nullopt;
    }
    return static_cast<std::size_t>(found - values_.begin());
}

void ValueBoard::end_gap(std::size_t index, Instant at) {
    Entry& entry = entries_[index];
    if (ever(index)) {
        ++entry.gaps.count;
        entry.gaps.stale_at = entry.available ? fresh_until(index) : at;
    }
    entry.gaps.fresh_since = at;
}

Instant ValueBoard::fresh_until(std::size_t index) const {
    const Entry& entry = entries_[index];
    return entry.available && values_[index].lasts != kForever
               ? later(entry.at, values_[index].lasts)
               : kNever;
}

}  // namespace tribus
