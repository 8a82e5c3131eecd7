#include <cstddef>
#include <nlohmann/json.hpp>

#include "app/wire/frames/frame_json.h"
#include "app/wire/sensors/sensor_text.h"
#include "transports/codecs/ibus_sensor/ibus_sensor.h"

namespace tribus {
namespace {

using OrderedJson = nlohmann::ordered_json;

OrderedJson fields_json(const std::vector<WrittenField>& fields) {
    OrderedJson list = OrderedJson::array();
    for (const WrittenField& field : fields) {
        OrderedJson object{{"name", field.name}, {"number", nullptr}, {"unit", field.unit}};
        if (field.number) {
            object["number"] = std::stod(*field.number);
        }
        list.push_back(std::move(object));
    }
    return list;
}

OrderedJson address_json(std::size_t address, const SensorAddressCounts& counts,
                         const SensorTypes& types) {
    OrderedJson object{{"address", address}, {"type", nullptr}};
    if (counts.type) {
        object["type"] = name_of_type(*counts.type, types);
    }
    object["requests"] = counts.requests;
    object["replies"] = counts.replies;
    object["misses"] = counts.misses;
    object["probes"] = counts.probes;
    if (const auto times = summary_of(counts.response_times)) {
        object["response_us"] = {{"least", whole_microseconds(times->least)},
                                 {"median", whole_microseconds(times->median)},
                                 {"most", whole_microseconds(times->most)}};
    }
    return object;
}

OrderedJson counts_json(const SensorTally& tally, const SensorCounts& counts) {
    OrderedJson rejected = OrderedJson::object();
    for (const NamedCount& cause : tally.frames.rejected) {
        rejected[std::string(cause.name)] = cause.count;
    }
    return {{"bytes", tally.frames.bytes},
            {"frames", tally.frames.frames},
            {"rejected", std::move(rejected)},
            {"skipped_bytes", tally.frames.skipped_bytes},
            {"servo_frames", tally.servo_frames},
            {"requests", counts.requests},
            {"replies", counts.replies},
            {"misses", counts.misses},
            {"misses_asked_again", counts.misses_asked_again},
            {"probes", counts.probes},
            {"discover", counts.discover},
            {"type", counts.type},
            {"value", counts.value},
            {"power_up", counts.power_up},
            {"echoes", counts.echoes},
            {"unasked", counts.unasked}};
}

}  // namespace

void append_sensor_json(std::string& text, const SensorExchange& exchange,
                        const SensorTypes& types) {
    const ExplainedExchange explained = explain(exchange, types);
    OrderedJson object = OrderedJson::object();
    if (exchange.asked.start) {
        object["t_us"] = whole_microseconds(*exchange.asked.start);
    }
    object["protocol"] = kSensorBusName;
    object["address"] = exchange.asked.frame.address;
    object["asked"] = explained.asked;
    object["answer"] = explained.answer;
    if (exchange.response_time) {
        object["response_us"] = whole_microseconds(*exchange.response_time);
    }
    if (exchange.outcome == SensorOutcome::missed) {
        object["asked_again"] = exchange.asked_again;
    }
    if (exchange.echoes > 0) {
        object["echoes"] = exchange.echoes;
    }
    if (exchange.type) {
        object["type"] = explained.type;
        object["type_id"] = exchange.type->id;
    }
    if (explained.data != nullptr) {
        const auto payload = explained.data->payload();
        object["data"] = std::vector<unsigned>(payload.begin(), payload.end());
    }
    if (explained.raw) {
        object["raw"] = *explained.raw;
    }
    if (!explained.fields.empty()) {
        object["values"] = fields_json(explained.fields);
    }
    text += object.dump();
    text += '\n';
}

void append_sensor_summary_json(std::string& text, const SensorTally& tally,
                                const SensorConversation& conversation, const SensorTypes& types,
                                std::string_view input) {
    OrderedJson summary = counts_json(tally, conversation.counts());
    OrderedJson addresses = OrderedJson::array();
    for (std::size_t address = 1; address <= kMostSensors; ++address) {
        const SensorAddressCounts& at = conversation.addresses()[address];
        if (at.requests + at.probes > 0) {
            addresses.push_back(address_json(address, at, types));
        }
    }
    summary["addresses"] = std::move(addresses);
    summary["input"] = input;
    text += OrderedJson{{"summary", std::move(summary)}}.dump();
    text += '\n';
}

}  // namespace tribus
