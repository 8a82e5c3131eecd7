#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace tribus {

/// Calls `take` for each part without damage, and `damage` for each damaged byte between them.
/// `damaged[i]` is true if byte i was damaged on the line.
template <class DamagedMarks, class Take, class Damage>
void for_undamaged_parts(std::span<const std::uint8_t> bytes, const DamagedMarks& damaged,
                         Take take, Damage damage) {
    std::size_t start = 0;
    for (std::size_t position = 0; position < bytes.size(); ++position) {
        if (damaged[position]) {
            take(bytes.subspan(start, position - start));
            damage();
            start = position + 1;
        }
    }
    take(bytes.subspan(start));
}

}  // namespace tribus
