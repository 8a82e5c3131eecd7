#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "app/state_text/cause_text.h"
#include "app/state_text/part_text.h"
#include "app/status/field_tables.h"
#include "app/status/field_values.h"
#include "config/schema/choices.h"

namespace tribus::sensor_bus_fields {
namespace {

using namespace field_values;

/// A field of the other role.
OrderedJson no_field() {
    return OrderedJson::value_t::discarded;
}

OrderedJson found_sensors(const StatusPart& part) {
    if (!of<SensorBusState>(part).is_receiver) {
        return no_field();
    }
    const SensorTypes types(of<SensorBusConfig>(part).dialect,
                            part.report.configuration->sensor_types);
    OrderedJson json = OrderedJson::array();
    for (std::size_t i = 0; i < of<SensorBusState>(part).found_count; ++i) {
        const FoundSensor& found = of<SensorBusState>(part).found[i];
        const SensorType* type = types.find(found.type);
        json.push_back({{"address", i + 1},
                        {"type", type == nullptr ? OrderedJson() : OrderedJson(type->name)},
                        {"type_id", found.type},
                        {"bytes", found.size}});
    }
    return json;
}

constexpr std::array<std::string_view, 3> kFaults{"none", "no_type", "wrong_size"};

OrderedJson sensor_faults(const StatusPart& part) {
    if (!of<SensorBusState>(part).is_receiver) {
        return no_field();
    }
    OrderedJson json = OrderedJson::array();
    const SensorFaults& faults = of<SensorBusState>(part).faults;
    for (std::size_t i = 0; i < faults.size(); ++i) {
        if (faults[i].kind != SensorFault::Kind::none) {
            json.push_back(
                {{"address", i + 1},
                 {"fault", kFaults[static_cast<std::size_t>(faults[i].kind)]},
                 {"sent_bytes",
                  faults[i].sent_size == 0 ? OrderedJson() : OrderedJson(faults[i].sent_size)}});
        }
    }
    return json;
}

/// "reads external voltage at address 1; address 3 never reports its type"
std::string receiver_text(const StatusPart& part) {
    const auto& bus = of<SensorBusState>(part);
    const SensorTypes types(of<SensorBusConfig>(part).dialect,
                            part.report.configuration->sensor_types);
    std::vector<std::string> reads;
    std::vector<std::string> parts;
    for (std::size_t i = 0; i < bus.found_count; ++i) {
        const SensorType* const type = types.find(bus.found[i].type);
        reads.push_back(fmt::format("{} at address {}",
                                    type == nullptr
                                        ? fmt::format("unknown type {:02x}", bus.found[i].type)
                                        : in_words(type->name),
                                    i + 1));
    }
    parts.push_back(reads.empty() ? "waits for a sensor that answers"
                                  : fmt::format("reads {}", fmt::join(reads, ", ")));
    for (std::size_t i = 0; i < bus.faults.size(); ++i) {
        const SensorFault& fault = bus.faults[i];
        if (fault.kind == SensorFault::Kind::no_type) {
            parts.push_back(fmt::format("address {} never reports its type", i + 1));
        } else if (fault.kind == SensorFault::Kind::wrong_size) {
            parts.push_back(
                fmt::format("address {} sends values of {} bytes, another size than it "
                            "reported",
                            i + 1, fault.sent_size));
        }
    }
    return fmt::format("{}", fmt::join(parts, "; "));
}

OrderedJson text(const StatusPart& part) {
    const auto& bus = of<SensorBusState>(part);
    if (bus.is_receiver) {
        return receiver_text(part);
    }
    if (!is_asked(bus.latest_request, part.report.now)) {
        return bus.latest_request ? "the receiver sends no more requests; waits for one"
                                  : "waits for the first request of a receiver";
    }
    return bus.first_address == 0 ? "a receiver sends requests; waiting for an address"
                                  : "answers the receiver";
}

OrderedJson counts(const StatusPart& part) {
    if (of<SensorBusState>(part).is_receiver) {
        const ReceiverRoleCounts& counts = of<SensorBusState>(part).receiver;
        return {{"requests", counts.requests},
                {"replies", counts.replies},
                {"misses", counts.misses},
                {"wrong", counts.wrong},
                {"lost_sensors", counts.lost_sensors},
                {"dropped", counts.dropped}};
    }
    const SensorRoleCounts& counts = of<SensorBusState>(part).sensor;
    return {{"requests", counts.requests},
            {"answered", counts.answered},
            {"late", counts.late},
            {"stale", counts.stale},
            {"dropped", counts.dropped}};
}

OrderedJson first_address(const StatusPart& part) {
    const auto address = of<SensorBusState>(part).first_address;
    return of<SensorBusState>(part).is_receiver ? no_field()
           : address == 0                       ? OrderedJson()
                                                : OrderedJson(address);
}
OrderedJson sensors(const StatusPart& part) {
    return of<SensorBusState>(part).is_receiver
               ? no_field()
               : OrderedJson(of<SensorBusConfig>(part).sensors.size());
}
OrderedJson request_age(const StatusPart& part) {
    const auto& request = of<SensorBusState>(part).latest_request;
    return of<SensorBusState>(part).is_receiver ? no_field()
           : request                            ? OrderedJson(us(part.report.now - *request))
                                                : OrderedJson();
}
OrderedJson collisions(const StatusPart& part) {
    return of<SensorBusState>(part).echo.collisions;
}

constexpr StatusField kFields[]{
    {"name", FieldKind::text, "as configured", member<&SensorBusConfig::name>},
    {"port", FieldKind::text, "its device", member<&SensorBusConfig::port>},
    {"role",
     FieldKind::word,
     "as configured",
     [](const StatusPart& part) { return OrderedJson(word_of(of<SensorBusConfig>(part).role)); },
     {.words = ChoiceWords<BusRole>::kAll}},
    {"text", FieldKind::text, "what it does, and what it waits for", text},
    {"found",
     FieldKind::other,
     "role `receiver`: the sensors that reported their type",
     found_sensors,
     {.optional = true,
      .shape = "{ address: number; type: string | null; type_id: number; bytes: number }[]"}},
    {"faults",
     FieldKind::other,
     "role `receiver`: sensors that answer but cannot be read: `no_type` (it never reports its "
     "type), `wrong_size` (its values have `sent_bytes`, not the `bytes` that it reported)",
     sensor_faults,
     {.optional = true,
      .shape = "{ address: number; fault: string; sent_bytes: number | null }[]"}},
    {"first_address",
     FieldKind::amount,
     "role `sensor`: `null` while it waits for one",
     first_address,
     {.may_be_null = true, .optional = true}},
    {"sensors", FieldKind::amount, "role `sensor`: how many it has", sensors, {.optional = true}},
    {"request_age_us",
     FieldKind::time,
     "role `sensor`: age of the latest request",
     request_age,
     {.may_be_null = true, .optional = true}},
    {"counts",
     FieldKind::counters,
     "role `receiver`: `requests`, `replies`, `misses`, `wrong`, `lost_sensors`, `dropped`; role "
     "`sensor`: `requests`, `answered`, `late`, `stale`, `dropped`",
     counts,
     {.metric = "messages_total", .metric_label = "what"}},
    {"collisions", FieldKind::counter, "bytes that came back other than sent", collisions},
};

}  // namespace

constexpr PartKind kKind{
    "sensor_buses",
    "sensor_bus",
    "bus",
    "",
    kFields,
    [](const StatusReport& all) { return all.sensor_buses.size(); },
    [](const StatusPart& part) -> std::string_view { return of<SensorBusConfig>(part).name; }};

}  // namespace tribus::sensor_bus_fields
