#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "config/language/nearest.h"
#include "config/read/values.h"
#include "config/schema/choices.h"
#include "core/quotes.h"
#include "transports/codecs/ibus_sensor/ibus_sensor.h"
#include "transports/links/serial/serial_medium.h"

namespace tribus {
namespace {

constexpr std::array<std::string_view, 5> kSensorRoleKeys{"sensor", "address", "chain",
                                                          "reply_after", "reply_within"};
constexpr std::array<std::string_view, 5> kReceiverRoleKeys{"slot", "power_up", "probe_every",
                                                            "drop_after", "timeout"};
constexpr std::uint32_t kBaud = 115200;

std::span<const std::string_view> keys_of_other(BusRole role) {
    return role == BusRole::sensor ? kReceiverRoleKeys : kSensorRoleKeys;
}

void check_role_keys(const TableContent& content, BusRole role, Mistakes& mistakes) {
    const BusRole other = role == BusRole::sensor ? BusRole::receiver : BusRole::sensor;
    for (const std::string_view key : keys_of_other(role)) {
        if (content.given(key)) {
            mistakes.add(content.find(key)->where,
                         fmt::format("{} is for role {}; leave it out", in_quotes(key),
                                     in_quotes(word_of(other))));
        }
    }
}

std::vector<std::string_view> type_names(const SensorTypes& types) {
    std::vector<std::string_view> names;
    for (const SensorType& type : types.all()) {
        names.emplace_back(type.name);
    }
    return names;
}

/// Hint for a misspelt name, because the list of names is too long to print.
std::string near_name(std::string_view wrong, std::span<const std::string_view> names) {
    const auto near = nearest(wrong, names);
    return near ? fmt::format("did you mean {}? ", in_quotes(*near)) : std::string();
}

void read_fields(const TableContent& content, SensorConfig& sensor, Reading reading) {
    const Entry* values = content.find("values");
    if (values == nullptr) {
        return;
    }
    std::vector<std::string_view> fields;
    for (const SensorField& field : sensor.type.fields) {
        fields.emplace_back(field.name);
    }
    for (const NamedText& named : read_texts(*values, "the name of a value", reading.mistakes)) {
        const auto field = std::ranges::find(fields, named.entry->key);
        if (field == fields.end()) {
            reading.mistakes.add(
                named.entry->where,
                fmt::format("type {} has no field {}; {}", in_quotes(sensor.type.name),
                            in_quotes(named.entry->key), suggestion(named.entry->key, fields)));
            continue;
        }
        const auto place = static_cast<std::size_t>(field - fields.begin());
        sensor.values[place] = named.text;
        sensor.where[place] = named.entry->value.where;
    }
}

void check_sources(const TableContent& content, const SensorConfig& sensor,
                   const std::string& title, Mistakes& mistakes) {
    const bool several = sensor.type.fields.size() > 1;
    if (content.given("value") && several) {
        mistakes.add(content.find("value")->where,
                     fmt::format("type {} has {} fields, so \"value\" is ambiguous; allowed: "
                                 "values = {{ {} = \"...\" }}",
                                 in_quotes(sensor.type.name), sensor.type.fields.size(),
                                 sensor.type.fields.front().name));
    } else if (!content.given("value") && !content.given("values")) {
        mistakes.add(content.where("value"),
                     fmt::format("{} lacks {}; required: the name of the value that it sends",
                                 title, several ? "\"values\"" : "\"value\""));
    } else if (content.given("value") && content.given("values")) {
        mistakes.add(content.find("values")->where,
                     "\"values\" and \"value\" are both given; leave one of them out");
    }
}

std::optional<SensorConfig> read_sensor(const Value& value, const std::string& title,
                                        const SensorTypes& types, Reading reading) {
    const auto* table = value.as<Table>();
    if (table == nullptr) {
        reading.mistakes.add(value.where, fmt::format("{} is {}; allowed: a table with \"type\" "
                                                      "and \"value\"",
                                                      title, describe(value)));
        return std::nullopt;
    }
    const TableContent content = read_table({*table, value.where, title}, sensor_keys(), reading);
    const auto* name = content.values().find_as<std::string>("type");
    if (name == nullptr) {
        return std::nullopt;
    }
    const SensorType* type = types.find(*name);
    if (type == nullptr) {
        reading.mistakes.add(
            content.where("type"),
            fmt::format(
                "{} is not a sensor type; {}allowed: {}, or one of your own, [sensor_type.NAME]",
                in_quotes(*name), near_name(*name, type_names(types)),
                in_quotes_all(type_names(types))));
        return std::nullopt;
    }
    SensorConfig sensor;
    sensor.type = *type;
    sensor.values.resize(type->fields.size());
    sensor.where.resize(type->fields.size(), value.where);
    if (const auto* source = content.values().find_as<std::string>("value")) {
        sensor.values.front() = *source;
        sensor.where.front() = content.where("value");
    }
    read_fields(content, sensor, reading);
    check_sources(content, sensor, title, reading.mistakes);
    content.read_into(sensor);
    return sensor;
}

void read_sensors(const TableContent& content, const std::string& title, const SensorTypes& types,
                  SensorBusConfig& config, Reading reading) {
    const Entry* entry = content.find("sensor");
    const auto* list = entry == nullptr ? nullptr : entry->value.as<List>();
    if (list == nullptr || list->items.empty()) {
        if (!reading.lost.affects(content.where("sensor"))) {
            reading.mistakes.add(content.where("sensor"),
                                 fmt::format("{} has no sensors; required with role \"sensor\": "
                                             "[{}.sensor]], each with \"type\" and \"value\"",
                                             title, title.substr(0, title.size() - 1)));
        }
        return;
    }
    const std::size_t room = config.chain ? kMostSensors : kMostSensors + 1U - config.address;
    if (list->items.size() > room) {
        reading.mistakes.add(
            list->items[room].where,
            fmt::format(
                "{} has {} sensors from address {} on; allowed: addresses up to {}, so at most {}",
                title, list->items.size(), config.address, kMostSensors, room));
    }
    for (std::size_t i = 0; i < list->items.size(); ++i) {
        const std::string which = fmt::format("sensor {} of {}", i + 1, title);
        if (auto sensor = read_sensor(list->items[i], which, types, reading)) {
            config.sensors.push_back(std::move(*sensor));
        }
    }
}

void check_reply_times(const TableContent& content, const SensorBusConfig& config,
                       Mistakes& mistakes) {
    if (config.reply_after >= config.reply_within && content.sound("reply_after") &&
        content.sound("reply_within")) {
        mistakes.add(content.where(content.given("reply_after") ? "reply_after" : "reply_within"),
                     "\"reply_after\" is not less than \"reply_within\", so no answer would be "
                     "sent; allowed: less than \"reply_within\"");
    }
}

}  // namespace

bool bus_role_has(BusRole role, std::string_view key) {
    const auto others = keys_of_other(role);
    return std::ranges::find(others, key) == others.end();
}

SensorType read_sensor_type(const Entry& entry, const Table& table, Reading reading) {
    const TableContent content =
        read_table({table, entry.value.where, fmt::format("[sensor_type.{}]", entry.key)},
                   sensor_type_keys(), reading);
    SensorType type;
    type.name = entry.key;
    content.read_into(type);
    SensorField field;
    field.name = entry.key;
    field.bits = type.size * 8U;
    content.read_into(field);
    if (field.scale == 0) {
        reading.mistakes.add(content.where("scale"),
                             "\"scale\" is 0, so every number would be the same; allowed: any "
                             "other number");
    }
    type.fields.push_back(std::move(field));
    return type;
}

SensorBusDraft read_sensor_bus(const Entry& entry, const Table& table, const Draft& draft,
                               Reading reading) {
    const std::string title = fmt::format("[sensor_bus.{}]", entry.key);
    const TableContent content =
        read_table({table, entry.value.where, title}, sensor_bus_keys(), reading);
    SensorBusDraft bus;
    SensorBusConfig& config = bus.config;
    config.name = entry.key;
    bus.where = entry.where;
    config.port.medium = &kSerialMedium;
    config.port.where = content.where("device");
    config.port.line.baud = kBaud;
    bus.port_sound = content.given("device") && content.sound("device");
    content.read_into(config.port);
    content.read_into(config);
    if (!content.given("role") || !content.sound("role")) {
        return bus;
    }
    check_role_keys(content, config.role, reading.mistakes);
    if (config.role == BusRole::sensor) {
        check_reply_times(content, config, reading.mistakes);
        read_sensors(content, title, SensorTypes(config.dialect, draft.sensor_types), config,
                     reading);
    }
    return bus;
}

}  // namespace tribus
