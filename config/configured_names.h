#pragma once

#include <string>
#include <vector>

namespace tribus {

/// Of the inputs of a configuration, its outputs and so on, in their order.
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
