#include "config/build/machine_mistakes.h"

#include <unistd.h>

#include <fmt/format.h>

#include "config/build/build.h"
#include "core/quotes.h"

namespace tribus {
std::vector<Mistake> mistaken_devices(const Configuration& configuration) {
    std::vector<Mistake> mistakes;
    for (const PortPlan& port : plan_ports(configuration)) {
        const Medium& medium = *port.config.medium;
        const std::string refusal =
            medium.refusal == nullptr ? std::string() : medium.refusal(port.config.device);
        if (!refusal.empty()) {
            mistakes.push_back({configuration.file, port.config.where,
                                fmt::format("{} is {}: {}", in_quotes(medium.place.key),
                                            in_quotes(port.config.device), refusal)});
        }
    }
    return mistakes;
}

std::vector<Mistake> mistaken_processor(const Configuration& configuration, int processors) {
    const auto& runtime = configuration.runtime;
    if (!runtime.cpu || *runtime.cpu < processors) {
        return {};
    }
    const std::string allowed =
        processors == 1 ? "0, its only one" : fmt::format("0 to {}", processors - 1);
    return {{configuration.file, runtime.cpu_where,
             fmt::format("\"cpu\" is {}, which this machine does not have; allowed: {}",
                         *runtime.cpu, allowed)}};
}

int configured_processors() {
    return static_cast<int>(::sysconf(_SC_NPROCESSORS_CONF));
}

}  // namespace tribus
