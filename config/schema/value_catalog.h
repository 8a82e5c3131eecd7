#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "config/schema/schema.h"
#include "core/value_board.h"
#include "pipelines/values/value_engine.h"
#include "transports/codecs/can_value_reader.h"

namespace tribus {

/// The parts of a configuration from which values may come.
struct ValueSources {
    std::vector<std::string_view> inputs;
    std::vector<std::string_view> outputs;
    std::vector<const SensorBusConfig*> buses;
    std::vector<const ValuesConfig*> values;
    std::vector<SensorType> own_types;
};
ValueSources value_sources(const Configuration& configuration);

/// Absent if the message could not be read from the configuration.
std::optional<AnyValueReader> make_reader(const ValueMessageConfig& config);
/// The base of a reader of either kind.
const ValueReader& common_part(const AnyValueReader& reader);

/// Whether anything provides or uses a value while the configuration runs.
bool needs_values(const Configuration& configuration);

/// Every value that has a name in the configuration, and its source.
struct ValueCatalog {
    /// Indices of the values of one [values.NAME] with a message.
    struct Message {
        const ValueMessageConfig* config = nullptr;
        std::vector<std::optional<std::size_t>> values;
    };
    /// Indices of the values of a bus in the receiver role.
    struct Readings {
        std::array<ReadingPlaces, kMostSensors> by_address;
        std::vector<TypePlaces> by_type;
    };

    /// Without buses and messages, which are built from the configuration and the members below.
    ValueEngineSettings settings;
    std::vector<Message> messages;
    std::vector<Readings> readings;  ///< one for each bus, empty for the sensor role

    /// Index of the value with that name.
    std::optional<std::size_t> find(std::string_view name) const;
};
ValueCatalog catalog_of(const ValueSources& sources);

}  // namespace tribus
