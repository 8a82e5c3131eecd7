#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "config/schema.h"
#include "core/value_board.h"
#include "pipelines/value_engine.h"
#include "transports/codecs/can_value_reader.h"

namespace tribus {

/// What values may come from.
struct ValueSources {
    std::vector<std::string_view> inputs;
    std::vector<std::string_view> outputs;
    std::vector<const SensorBusConfig*> buses;
    std::vector<const ValuesConfig*> values;
    std::vector<SensorType> own_types;
};
ValueSources value_sources(const Configuration& configuration);

/// Null where the message could not be read from the configuration.
std::unique_ptr<CanValueReader> make_reader(const ValueMessageConfig& config);

/// Whether anything says or asks for a value while the configuration runs.
bool needs_values(const Configuration& configuration);

/// Every value that a configuration has a name for, and where each comes from.
struct ValueCatalog {
    /// Where the values of one [values.NAME] with a message go.
    struct Message {
        const ValueMessageConfig* config = nullptr;
        std::vector<std::optional<std::size_t>> values;
    };
    /// Where what a bus in the receiver role says goes.
    struct Readings {
        std::array<ReadingPlaces, kMostSensors> by_address;
        std::vector<TypePlaces> by_type;
    };

    /// But for its buses and messages, which are made of the configuration and of the following.
    ValueEngineSettings settings;
    std::vector<Message> messages;
    std::vector<Readings> readings;  ///< one for each bus; of sensors empty

    std::optional<std::size_t> find(std::string_view name) const;
};
ValueCatalog catalog_of(const ValueSources& sources);

}  // namespace tribus
