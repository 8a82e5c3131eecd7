#include "app/status/sensor_bus_json.h"

#include <chrono>
#include <cstddef>
#include <string_view>

#include <nlohmann/json.hpp>

#include "config/schema/choices.h"

namespace tribus {
namespace {

using OrderedJson = nlohmann::ordered_json;

OrderedJson found_sensors(const SensorBusState& state, const SensorTypes& types) {
    OrderedJson json = OrderedJson::array();
    for (std::size_t i = 0; i < state.found_count; ++i) {
        const SensorType* type = types.find(state.found[i].type);
        json.push_back({{"address", i + 1},
                        {"type", type == nullptr ? OrderedJson() : OrderedJson(type->name)},
                        {"type_id", state.found[i].type},
                        {"bytes", state.found[i].size}});
    }
    return json;
}

std::string_view word_of(SensorFault::Kind fault) {
    switch (fault) {
        case SensorFault::Kind::none:
            break;
        case SensorFault::Kind::no_type:
            return "no_type";
        case SensorFault::Kind::wrong_size:
            return "wrong_size";
    }
    return "none";
}

OrderedJson sensor_faults(const SensorBusState& state) {
    OrderedJson json = OrderedJson::array();
    for (std::size_t i = 0; i < state.faults.size(); ++i) {
        const SensorFault& fault = state.faults[i];
        if (fault.kind != SensorFault::Kind::none) {
            json.push_back({{"address", i + 1},
                            {"fault", word_of(fault.kind)},
                            {"sent_bytes",
                             fault.sent_size == 0 ? OrderedJson() : OrderedJson(fault.sent_size)}});
        }
    }
    return json;
}

std::int64_t microseconds_since(Instant at, Instant now) {
    return std::chrono::duration_cast<std::chrono::microseconds>(now - at).count();
}

}  // namespace

OrderedJson sensor_bus_json(const SensorBusConfig& config, const SensorBusState& state,
                            const StatusReport& report) {
    OrderedJson json;
    json["name"] = config.name;
    json["port"] = config.port.device;
    json["role"] = word_of(config.role);
    if (state.is_receiver) {
        const SensorTypes types(config.dialect, report.configuration->sensor_types);
        const ReceiverRoleCounts& counts = state.receiver;
        json["found"] = found_sensors(state, types);
        json["faults"] = sensor_faults(state);
        json["counts"] = {{"requests", counts.requests},
                          {"replies", counts.replies},
                          {"misses", counts.misses},
                          {"wrong", counts.wrong},
                          {"lost_sensors", counts.lost_sensors},
                          {"dropped", counts.dropped}};
    } else {
        const SensorRoleCounts& counts = state.sensor;
        json["first_address"] =
            state.first_address == 0 ? OrderedJson() : OrderedJson(state.first_address);
        json["sensors"] = config.sensors.size();
        json["request_age_us"] =
            state.latest_request
                ? OrderedJson(microseconds_since(*state.latest_request, report.now))
                : OrderedJson();
        json["counts"] = {{"requests", counts.requests},
                          {"answered", counts.answered},
                          {"late", counts.late},
                          {"stale", counts.stale},
                          {"dropped", counts.dropped}};
    }
    json["collisions"] = state.echo.collisions;
    return json;
}

}  // namespace tribus
