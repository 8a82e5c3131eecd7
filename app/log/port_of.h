#pragma once

#include <algorithm>
#include <cstddef>

#include "app/appliance/appliance.h"
#include "pipelines/stations/station.h"

namespace tribus {

/// Index of the port at which a part sits; each part has one.
inline std::size_t port_of(const Appliance& appliance, const Station& station) {
    const auto has_it = [&station](const PortPlan& plan) {
        const auto& stations = plan.wiring.stations;
        return std::ranges::find(stations, station) != stations.end();
    };
    return static_cast<std::size_t>(std::ranges::find_if(appliance.ports(), has_it) -
                                    appliance.ports().begin());
}

}  // namespace tribus
