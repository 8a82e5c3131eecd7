#pragma once

#include <algorithm>
#include <utility>
#include <vector>

namespace tribus {

/// Calls `check(earlier, later)` for each pair, in the order of the file. `line_of` returns the
/// line of a part. Parts of one line keep their order.
template <class Part, class LineOf, class Check>
void for_each_pair(std::vector<Part> parts, LineOf line_of, Check check) {
    std::ranges::stable_sort(parts, {}, line_of);
    for (const Part& later : parts) {
        for (const Part& earlier : parts) {
            if (&earlier == &later) {
                break;
            }
            check(earlier, later);
        }
    }
}

}  // namespace tribus
