#pragma once

#include "config/read/draft.h"
#include "config/read/table.h"

namespace tribus {

/// Reads [values.NAME].
ValuesDraft read_values(const Entry& entry, const Table& table, Reading reading);

/// Reads [sensor_type.NAME].
SensorType read_sensor_type(const Entry& entry, const Table& table, Reading reading);

/// Reads [sensor_bus.NAME] with the sensor types of the draft.
SensorBusDraft read_sensor_bus(const Entry& entry, const Table& table, const Draft& draft,
                               Reading reading);

/// Whether a bus with that role can have the key.
bool bus_role_has(BusRole role, std::string_view key);

/// An entry of { NAME = text }. `read_texts` returns the valid ones. `what` says in messages what a
/// text is.
struct NamedText {
    const Entry* entry = nullptr;
    std::string text;
};
std::vector<NamedText> read_texts(const Entry& entry, std::string_view what, Mistakes& mistakes);

}  // namespace tribus
