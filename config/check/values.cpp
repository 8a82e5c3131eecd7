#include "config/check/values.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "config/language/nearest.h"
#include "config/schema/value_catalog.h"
#include "core/quotes.h"
#include "core/unit.h"

namespace tribus {
namespace {

constexpr std::array<std::string_view, 3> kOwnNames{"input", "output", "machine"};

ValueSources value_sources(const Draft& draft) {
    ValueSources sources;
    for (const InputDraft& input : draft.inputs) {
        sources.inputs.emplace_back(input.config.name);
    }
    for (const OutputDraft& output : draft.outputs) {
        sources.outputs.emplace_back(output.config.name);
    }
    for (const SensorBusDraft& bus : draft.sensor_buses) {
        sources.buses.push_back(&bus.config);
    }
    for (const ValuesDraft& values : draft.values) {
        sources.values.push_back(&values.config);
    }
    sources.own_types = draft.sensor_types;
    return sources;
}

/// Checks names of values against all values of the configuration.
class NameCheck {
  public:
    NameCheck(const Draft& draft, Reading reading)
        : catalog_(catalog_of(value_sources(draft))),
          reading_(reading),
          all_known_(draft.value_names_known && draft.input_names_known &&
                     draft.output_names_known) {
        for (const NamedValue& value : catalog_.settings.values) {
            names_.emplace_back(value.name);
        }
        for (const ValuesDraft& values : draft.values) {
            if (!values.sound) {
                unsound_.emplace_back(values.config.name);
            }
        }
    }

    const NamedValue* find(const std::string& name, Location where) {
        const auto index = catalog_.find(name);
        if (index) {
            return &catalog_.settings.values[*index];
        }
        const std::string first_word = name.substr(0, name.find('.'));
        const bool perhaps_there = !all_known_ || reading_.lost.mentions(first_word) ||
                                   std::ranges::find(unsound_, first_word) != unsound_.end();
        if (!perhaps_there) {
            const auto near = nearest(name, names_);
            reading_.mistakes.add(
                where,
                fmt::format(
                    "there is no value {}; {}", in_quotes(name),
                    near ? fmt::format("did you mean {}?", in_quotes(*near))
                         : std::string("values are the signals of [values.NAME], the readings of a "
                                       "[sensor_bus.NAME] with role \"receiver\", and facts such "
                                       "as input.NAME.age and machine.load")));
        }
        return nullptr;
    }

  private:
    ValueCatalog catalog_;
    Reading reading_;
    bool all_known_;
    std::vector<std::string_view> names_;
    /// Tables with values that are unknown because of another mistake.
    std::vector<std::string> unsound_;
};

/// Where a value is sent, in words.
struct SentTo {
    std::string_view unit;
    std::string_view sink;
    std::string_view advice;
};

void check_unit(const NamedValue& value, const SentTo& to, Location where, Mistakes& mistakes) {
    if (may_be_sent(value.unit, to.unit)) {
        return;
    }
    const auto unknown = [](std::string_view unit) {
        return is_known_unit(unit) ? "" : ", an unknown unit";
    };
    mistakes.add(where, fmt::format("{} is in {}{}, but {} {}{}; {}", in_quotes(value.name),
                                    in_quotes(value.unit), unknown(value.unit), to.sink,
                                    in_quotes(to.unit), unknown(to.unit), to.advice));
}

void check_use(const ValueUse& used, NameCheck& names, Mistakes& mistakes) {
    const NamedValue* value = names.find(used.use.name, used.where);
    if (value != nullptr && !(used.use.takes_pulses && value->unit == "us")) {
        check_unit(*value,
                   {used.use.unit, "is sent here in",
                    "name a value whose unit converts, or correct the unit that is wrong"},
                   used.where, mistakes);
    }
}

/// A field that no value feeds is sent as 0, and half of a position is another place.
void check_position(const SensorConfig& sensor, Mistakes& mistakes) {
    constexpr std::array<std::string_view, 2> kCoordinates{"latitude", "longitude"};
    const auto& fields = sensor.type.fields;
    std::vector<std::size_t> missing;
    for (const std::string_view coordinate : kCoordinates) {
        const auto field = std::ranges::find(fields, coordinate, &SensorField::name);
        if (field == fields.end()) {
            return;
        }
        const auto place = static_cast<std::size_t>(field - fields.begin());
        if (sensor.values.at(place).empty()) {
            missing.push_back(place);
        }
    }
    if (!missing.empty()) {
        mistakes.add(sensor.where[missing.front()],
                     fmt::format("{} sends a position, and {} of it would be 0; latitude and "
                                 "longitude are needed, both",
                                 in_quotes(sensor.type.name),
                                 missing.size() == 1 ? in_quotes(fields[missing.front()].name)
                                                     : std::string("both")));
    }
}

void check_sensors(const SensorBusConfig& bus, NameCheck& names, Mistakes& mistakes) {
    for (const SensorConfig& sensor : bus.sensors) {
        check_position(sensor, mistakes);
        for (std::size_t i = 0; i < sensor.values.size(); ++i) {
            if (sensor.values[i].empty()) {
                continue;
            }
            const NamedValue* value = names.find(sensor.values[i], sensor.where[i]);
            if (value != nullptr && !sensor.scale) {
                check_unit(*value,
                           {sensor.type.fields[i].unit, "this sensor sends",
                            "add scale = N, the factor for the value (scale = 1: unchanged)"},
                           sensor.where[i], mistakes);
            }
        }
    }
}

void check_own_names(const Draft& draft, Mistakes& mistakes) {
    std::map<std::string_view, Location> seen;
    const auto check = [&](std::string_view kind, const std::string& name, Location where) {
        if (std::ranges::find(kOwnNames, name) != kOwnNames.end()) {
            mistakes.add(
                where, fmt::format(
                           "{} is reserved for the program's own values; give [{}.{}] another name",
                           in_quotes(name), kind, name));
        } else if (!seen.emplace(name, where).second) {
            mistakes.add(where, fmt::format("{} is also the name of a sensor bus, so their values "
                                            "would have the same names; give [{}.{}] another name",
                                            in_quotes(name), kind, name));
        }
    };
    for (const SensorBusDraft& bus : draft.sensor_buses) {
        check("sensor_bus", bus.config.name, bus.where);
    }
    for (const ValuesDraft& values : draft.values) {
        check("values", values.config.name, values.where);
    }
}

void check_own_types(const Draft& draft, Mistakes& mistakes) {
    std::map<std::uint8_t, std::string_view> names;
    auto place = draft.sensor_type_places.begin();
    for (const SensorType& type : draft.sensor_types) {
        const Location where = *place++;
        const auto [known, first] = names.emplace(type.id, type.name);
        if (!first) {
            mistakes.add(where, fmt::format("[sensor_type.{}] has the id {}, and so has "
                                            "[sensor_type.{}]; give one of them another id",
                                            type.name, type.id, known->second));
        }
    }
}

}  // namespace

void check_values(const Draft& draft, Reading reading) {
    check_own_names(draft, reading.mistakes);
    check_own_types(draft, reading.mistakes);
    NameCheck names(draft, reading);
    for (const SensorBusDraft& bus : draft.sensor_buses) {
        check_sensors(bus.config, names, reading.mistakes);
    }
    for (const OutputDraft& output : draft.outputs) {
        for (const ValueUse& use : output.used_values) {
            check_use(use, names, reading.mistakes);
        }
    }
}

}  // namespace tribus
