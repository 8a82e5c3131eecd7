#pragma once

#include "config/draft.h"
#include "config/read_table.h"

namespace tribus {

/// [values.NAME]
ValuesDraft read_values(const Entry& entry, const Table& table, Reading reading);

/// [sensor_type.NAME]
SensorType read_sensor_type(const Entry& entry, const Table& table, Reading reading);

/// [sensor_bus.NAME], with the types of the draft.
SensorBusDraft read_sensor_bus(const Entry& entry, const Table& table, const Draft& draft,
                               Reading reading);

/// { NAME = text }: the entries that are sound, with the places of their texts. `what` says what a
/// text is, for messages.
struct NamedText {
    const Entry* entry = nullptr;
    std::string text;
};
std::vector<NamedText> read_texts(const Entry& entry, std::string_view what, Mistakes& mistakes);

/// What is wrong with named values beside each other: names that nobody gives, units that do not
/// fit, devices that cannot be shared.
void check_values(const Draft& draft, Reading reading);

}  // namespace tribus
