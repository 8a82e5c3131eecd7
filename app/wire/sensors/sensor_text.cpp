#include "app/wire/sensors/sensor_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstddef>
#include <iterator>

#include "app/wire/frames/frame_json.h"
#include "app/wire/frames/frame_text.h"

namespace tribus {
namespace {

std::string microseconds_or(const std::optional<Duration>& duration, std::string_view otherwise) {
    return duration ? fmt::format("{}", whole_microseconds(*duration)) : std::string(otherwise);
}

std::string address_text(const SensorFrame& asked) {
    return asked.command == SensorCommand::power_up ? "-" : fmt::format("{}", asked.address);
}

std::string data_text(const SensorFrame& frame) {
    return fmt::format("{:02x}", fmt::join(frame.payload(), " "));
}

/// ` -0.01 V`; with field names if there are several fields.
std::string fields_text(const std::vector<WrittenField>& fields) {
    std::string text;
    for (const WrittenField& field : fields) {
        const std::string name = fields.size() > 1 ? field.name + " " : "";
        const std::string unit = field.unit.empty() || !field.number ? "" : " " + field.unit;
        text += fmt::format("{} {}{}{}", text.empty() ? "" : ",", name,
                            field.number.value_or("not available"), unit);
    }
    return text;
}

std::string value_text(const ExplainedExchange& explained) {
    if (!explained.fields.empty()) {
        return explained.type + fields_text(explained.fields);
    }
    const bool reported = !explained.type.empty();
    const std::string raw = explained.raw ? fmt::format("{} ", *explained.raw) : "";
    return fmt::format("raw {}({}), {}{}", raw, data_text(*explained.data),
                       reported ? "unknown type " : "type not seen", explained.type);
}

std::string answer_text(const SensorExchange& exchange, const ExplainedExchange& explained) {
    switch (exchange.outcome) {
        case SensorOutcome::missed:
            return exchange.asked_again ? "no answer, asked again" : "no answer";
        case SensorOutcome::free:
            return "no answer: address is free";
        case SensorOutcome::cut:
            return "end of the recording";
        case SensorOutcome::power_up:
            return "power-up frame";
        case SensorOutcome::answered:
        case SensorOutcome::unasked:
            break;
    }
    if (explained.data == nullptr) {
        return "here";
    }
    if (explained.data->command == SensorCommand::type) {
        return fmt::format("{} (0x{:02X}), {} bytes", explained.type, explained.data->data[0],
                           explained.data->data[1]);
    }
    return value_text(explained);
}

void append_address_text(std::string& text, std::size_t address, const SensorAddressCounts& counts,
                         const SensorTypes& types) {
    if (counts.requests == 0) {
        text += fmt::format("address {}: free, {} probes\n", address, counts.probes);
        return;
    }
    const std::string type = counts.type ? name_of_type(*counts.type, types) : "type not seen";
    text += fmt::format("address {}: {}, {} requests, {} replies, {} misses", address, type,
                        counts.requests, counts.replies, counts.misses);
    if (const auto times = summary_of(counts.response_times)) {
        text += fmt::format(", answers after {} to {} us, median {} us",
                            whole_microseconds(times->least), whole_microseconds(times->most),
                            whole_microseconds(times->median));
    }
    text += '\n';
}

}  // namespace

void append_sensor_text_heading(std::string& text) {
    text += fmt::format("{:>12} {:>7} {:<8} {:>8}  {}\n", "t_us", "address", "asked", "after_us",
                        "answer");
}

void append_sensor_text(std::string& text, const SensorExchange& exchange,
                        const SensorTypes& types) {
    const ExplainedExchange explained = explain(exchange, types);
    const bool asked = exchange.outcome != SensorOutcome::unasked;
    text += fmt::format(
        "{:>12} {:>7} {:<8} {:>8}  {}{}{}\n", microseconds_or(exchange.asked.start, "-"),
        address_text(exchange.asked.frame), asked ? explained.asked : "-",
        microseconds_or(exchange.response_time, "-"), answer_text(exchange, explained),
        asked ? "" : ", without a request", exchange.echoes > 0 ? "  (echo)" : "");
}

void append_sensor_summary_text(std::string& text, const SensorTally& tally,
                                const SensorConversation& conversation, const SensorTypes& types) {
    append_summary_text(text, tally.frames);
    const SensorCounts& counts = conversation.counts();
    text += fmt::format(
        "{} requests, {} replies, {} misses ({} asked again at once), {} probes of free "
        "addresses\n"
        "{} discover, {} type, {} value, {} power-up frames, {} servo frames, {} echoes, "
        "{} answers without a request\n",
        counts.requests, counts.replies, counts.misses, counts.misses_asked_again, counts.probes,
        counts.discover, counts.type, counts.value, counts.power_up, tally.servo_frames,
        counts.echoes, counts.unasked);
    for (std::size_t address = 1; address <= kMostSensors; ++address) {
        const SensorAddressCounts& at = conversation.addresses()[address];
        if (at.requests + at.probes > 0) {
            append_address_text(text, address, at, types);
        }
    }
}

void append_sensor_csv_heading(std::string& text) {
    text += "t_us,address,asked,answer,response_us,type,data,raw,number,unit\n";
}

void append_sensor_csv(std::string& text, const SensorExchange& exchange,
                       const SensorTypes& types) {
    const ExplainedExchange explained = explain(exchange, types);
    std::vector<std::string> numbers;
    std::vector<std::string> units;
    for (const WrittenField& field : explained.fields) {
        numbers.push_back(field.number.value_or(""));
        units.push_back(field.unit);
    }
    text +=
        fmt::format("{},{},{},{},{},{},{},{},{},{}\n", microseconds_or(exchange.asked.start, ""),
                    exchange.asked.frame.address, explained.asked, explained.answer,
                    microseconds_or(exchange.response_time, ""), explained.type,
                    explained.data == nullptr ? "" : data_text(*explained.data),
                    explained.raw ? fmt::format("{}", *explained.raw) : "", fmt::join(numbers, ";"),
                    fmt::join(units, ";"));
}

}  // namespace tribus
