#include "config/check/warnings.h"

#include <algorithm>
#include <functional>
#include <tuple>

#include "config/check/absent_channels.h"

namespace tribus {

std::vector<Mistake> warnings_about(const Configuration& configuration) {
    std::vector<Mistake> all = maps_of_absent_channels(configuration);
    for (const Warning& warning : configuration.warnings) {
        all.push_back({configuration.file, warning.where, warning.text});
    }
    // Those of the whole file stand last: they say how many more there are.
    std::ranges::stable_sort(all, std::less{}, [](const Mistake& one) {
        return std::tuple(one.where.line == 0, one.where.line, one.where.column);
    });
    return all;
}

}  // namespace tribus
