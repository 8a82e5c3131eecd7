#include <memory>
#include <utility>
#include <variant>
#include <vector>

#include "config/build/build.h"
#include "config/schema/value_catalog.h"
#include "core/unit.h"

namespace tribus {
namespace {

/// Converts a named value to the number in a field of a sensor.
FieldSource field_source(const SensorConfig& sensor, std::size_t field, std::size_t value,
                         const NamedValue& named) {
    FieldSource source{.value = value, .factor = 1, .offset = sensor.offset};
    if (sensor.scale) {
        source.factor = *sensor.scale;
        return source;
    }
    // The checks have ensured that a conversion exists or that a unit is unknown.
    const auto conversion = unit_conversion(named.unit, sensor.type.fields[field].unit);
    if (conversion) {
        source.factor = conversion->factor;
        source.offset += conversion->offset;
    }
    return source;
}

SensorSettings sensor_settings(const SensorConfig& sensor, const ValueCatalog& catalog) {
    SensorSettings settings{.type = sensor.type, .sources = {}, .when_stale = sensor.not_available};
    for (std::size_t field = 0; field < sensor.values.size(); ++field) {
        const auto value = catalog.find(sensor.values[field]);
        settings.sources.push_back(
            value ? std::optional(
                        field_source(sensor, field, *value, catalog.settings.values[*value]))
                  : std::nullopt);
    }
    return settings;
}

SensorRoleSettings sensor_role(const SensorBusConfig& bus, const ValueCatalog& catalog) {
    SensorRoleSettings role;
    role.first_address = bus.chain ? std::nullopt : std::optional(bus.address);
    role.receives_echo = bus.wires != Wires::two;
    role.reply_after = bus.reply_after;
    role.reply_within = bus.reply_within;
    for (const SensorConfig& sensor : bus.sensors) {
        role.sensors.push_back(sensor_settings(sensor, catalog));
    }
    return role;
}

ReceiverRoleSettings receiver_role(const SensorBusConfig& bus,
                                   const ValueCatalog::Readings& readings, SensorTypes types) {
    return {.slot = bus.slot,
            .wires = bus.wires,
            .power_up_frames = bus.power_up,
            .probe_every = bus.probe_every,
            .drop_after = bus.drop_after,
            .types = std::move(types),
            .readings = readings.by_address,
            .first_of_type = readings.by_type};
}

}  // namespace

std::unique_ptr<ValueEngine> build_value_engine(const Configuration& configuration, Engine& engine,
                                                const WallClock* clock) {
    if (!needs_values(configuration)) {
        return nullptr;
    }
    ValueCatalog catalog = catalog_of(value_sources(configuration));
    std::vector<SensorBusSettings> buses;
    for (std::size_t i = 0; i < configuration.sensor_buses.size(); ++i) {
        const SensorBusConfig& bus = configuration.sensor_buses[i];
        SensorBusSettings& made = buses.emplace_back();
        if (bus.role == BusRole::receiver) {
            made = receiver_role(bus, catalog.readings[i],
                                 SensorTypes(bus.dialect, configuration.sensor_types));
        } else {
            made = sensor_role(bus, catalog);
        }
    }
    ValueEngineSettings settings = std::move(catalog.settings);
    settings.buses = std::move(buses);
    for (ValueCatalog::Message& message : catalog.messages) {
        AnyValueReader reader = *make_reader(*message.config);
        auto* const bytes = std::get_if<std::unique_ptr<ByteValueReader>>(&reader);
        if (clock != nullptr && bytes != nullptr) {
            (*bytes)->use_clock(*clock);
        }
        settings.messages.push_back(
            {.reader = std::move(reader), .values = std::move(message.values)});
    }
    auto values = std::make_unique<ValueEngine>(std::move(settings));
    for (std::size_t i = 0; i < configuration.outputs.size(); ++i) {
        engine.output(i).use(values->board());
    }
    return values;
}

}  // namespace tribus
