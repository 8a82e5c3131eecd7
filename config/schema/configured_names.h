#pragma once

#include <string>
#include <vector>

namespace tribus {

/// Names of the given inputs, outputs or other parts, in their order.
template <class Configs>
std::vector<std::string> configured_names(const Configs& configs) {
    std::vector<std::string> names;
    names.reserve(configs.size());
    for (const auto& config : configs) {
        names.push_back(config.name);
    }
    return names;
}

}  // namespace tribus
