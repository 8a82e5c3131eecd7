#include "config/schema/value_catalog.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <variant>

#include "pipelines/engine/machine_facts.h"
#include "transports/codecs/dbc/value_reader.h"
#include "transports/codecs/dronecan/value_reader.h"
#include "transports/registry/registry.h"

namespace tribus {
namespace {

/// Lifetime of facts about inputs and outputs. If they are not renewed in this time, the program
/// hangs.
constexpr Duration kHealthLasts = 5 * HealthWatch::kPeriod;
/// Lifetime of facts about the machine. The main thread reads them once per second.
constexpr Duration kMachineLasts = std::chrono::seconds(5);

class Catalog {
  public:
    explicit Catalog(const ValueSources& sources) : sources_(sources) {}

    ValueCatalog make() {
        for (const ValuesConfig* values : sources_.values) {
            if (const auto* constant = std::get_if<ConstantConfig>(&values->source)) {
                const std::size_t place = add(values->name, constant->unit, kForever);
                catalog_.settings.constants.push_back({.value = place, .number = constant->number});
            } else {
                add_message(values->name, std::get<ValueMessageConfig>(values->source));
            }
        }
        for (const SensorBusConfig* bus : sources_.buses) {
            add_readings(*bus);
        }
        add_health();
        for (const FactName& fact : kMachineFacts) {
            catalog_.settings.machine.push_back(
                add(fmt::format("machine.{}", fact.name), fact.unit, kMachineLasts));
        }
        return std::move(catalog_);
    }

  private:
    std::size_t add(std::string name, std::string_view unit, Duration lasts) {
        catalog_.settings.values.push_back({std::move(name), std::string(unit), lasts});
        return catalog_.settings.values.size() - 1;
    }

    void add_message(const std::string& name, const ValueMessageConfig& config) {
        ValueCatalog::Message& message = catalog_.messages.emplace_back();
        message.config = &config;
        const auto reader = make_reader(config);
        if (!reader) {
            return;
        }
        for (const ValueReader::Value& value : common_part(*reader).values()) {
            const auto renamed = std::ranges::find(config.names, value.name,
                                                   &std::pair<std::string, std::string>::second);
            const std::string& own = renamed == config.names.end() ? value.name : renamed->first;
            message.values.emplace_back(
                add(fmt::format("{}.{}", name, own), value.unit, config.timeout));
        }
    }

    void add_readings(const SensorBusConfig& bus) {
        ValueCatalog::Readings& readings = catalog_.readings.emplace_back();
        if (bus.role == BusRole::sensor) {
            return;
        }
        for (std::size_t i = 0; i < kMostSensors; ++i) {
            const std::string name = fmt::format("{}.{}", bus.name, i + 1);
            readings.by_address[i].fields = {add(name, {}, bus.timeout)};
            readings.by_address[i].raw = add(name + ".raw", {}, bus.timeout);
        }
        const SensorTypes types(bus.dialect, sources_.own_types);
        for (const SensorType& type : types.all()) {
            TypePlaces& places = readings.by_type.emplace_back();
            places.type = type.id;
            const std::string name = fmt::format("{}.{}", bus.name, type.name);
            for (const SensorField& field : type.fields) {
                const bool alone = type.fields.size() == 1;
                places.fields.push_back(add(alone ? name : fmt::format("{}.{}", name, field.name),
                                            field.unit, bus.timeout));
            }
        }
    }

    void add_health() {
        for (std::size_t input = 0; input < sources_.inputs.size(); ++input) {
            for (std::size_t fact = 0; fact < kInputFacts.size(); ++fact) {
                const auto& [name, unit] = kInputFacts[fact];
                add_fact(fmt::format("input.{}.{}", sources_.inputs[input], name), unit, input,
                         static_cast<InputFact>(fact));
            }
            add_channels("input", sources_.inputs[input], input);
        }
        for (std::size_t output = 0; output < sources_.outputs.size(); ++output) {
            for (std::size_t fact = 0; fact < kOutputFacts.size(); ++fact) {
                const auto& [name, unit] = kOutputFacts[fact];
                add_fact(fmt::format("output.{}.{}", sources_.outputs[output], name), unit, output,
                         static_cast<OutputFact>(fact));
            }
            add_channels("output", sources_.outputs[output], output);
        }
    }
    void add_channels(std::string_view kind, std::string_view name, std::size_t index) {
        for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
            const std::size_t place =
                add(fmt::format("{}.{}.channel.{}", kind, name, channel + 1), "us", kHealthLasts);
            catalog_.settings.channels.push_back({.value = place,
                                                  .of_output = kind == "output",
                                                  .index = index,
                                                  .channel = channel});
        }
    }
    template <class Fact>
    void add_fact(std::string name, std::string_view unit, std::size_t index, Fact fact) {
        const std::size_t place = add(std::move(name), unit, kHealthLasts);
        catalog_.settings.health.push_back({.value = place, .index = index, .fact = fact});
    }

    const ValueSources& sources_;
    ValueCatalog catalog_;
};

}  // namespace

ValueSources value_sources(const Configuration& configuration) {
    ValueSources sources;
    for (const InputConfig& input : configuration.inputs) {
        sources.inputs.emplace_back(input.name);
    }
    for (const OutputConfig& output : configuration.outputs) {
        sources.outputs.emplace_back(output.name);
    }
    for (const SensorBusConfig& bus : configuration.sensor_buses) {
        sources.buses.push_back(&bus);
    }
    for (const ValuesConfig& values : configuration.values) {
        sources.values.push_back(&values);
    }
    sources.own_types = configuration.sensor_types;
    return sources;
}

std::optional<AnyValueReader> make_reader(const ValueMessageConfig& config) {
    if (const auto* message = std::get_if<DroneCanValueSource>(&config.layout)) {
        return dronecan::make_value_reader(message->message, message->from, message->fd);
    }
    if (const auto* source = std::get_if<ByteValueSource>(&config.layout)) {
        SettingValues settings;
        if (source->key) {
            settings.set("key", *source->key);
        }
        return find_protocol(source->protocol)->make_value_reader(settings);
    }
    const auto& dbc = std::get<DbcValueSource>(config.layout).described;
    return dbc.messages.empty() ? std::nullopt
                                : std::optional<AnyValueReader>(
                                      std::make_unique<DbcValueReader>(dbc.messages.front()));
}

const ValueReader& common_part(const AnyValueReader& reader) {
    return std::visit([](const auto& any) -> const ValueReader& { return *any; }, reader);
}

bool needs_values(const Configuration& configuration) {
    return !configuration.sensor_buses.empty() ||
           std::ranges::any_of(configuration.outputs, [](const OutputConfig& output) {
               return output.protocol->value_names != nullptr &&
                      !output.protocol->value_names(output.settings).empty();
           });
}

std::optional<std::size_t> ValueCatalog::find(std::string_view name) const {
    const auto found = std::ranges::find(settings.values, name, &NamedValue::name);
    return found == settings.values.end()
               ? std::nullopt
               : std::optional(static_cast<std::size_t>(found - settings.values.begin()));
}

ValueCatalog catalog_of(const ValueSources& sources) {
    return Catalog(sources).make();
}

}  // namespace tribus
