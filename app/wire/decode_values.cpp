#include "app/wire/decode_values.h"

#include <span>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/cli/exit_status.h"
#include "app/wire/frames/frame_json.h"
#include "app/wire/frames/frame_text.h"

namespace tribus {
namespace {

/// A message that is complete.
struct ReadMessage {
    std::string_view protocol;
    /// When its last byte began.
    std::optional<Duration> at;
    std::span<const ValueReader::Value> values;
    std::span<const ValueReading> readings;

    /// Calls `take` with each value that has a number, and the number.
    template <class Take>
    void for_each(Take take) const {
        for (std::size_t i = 0; i < values.size(); ++i) {
            if (readings[i].state == ValueReading::State::number) {
                take(values[i], readings[i].number);
            }
        }
    }
};

std::string time_text(const ReadMessage& message) {
    return message.at ? fmt::format("{}", whole_microseconds(*message.at)) : std::string();
}

void append_message_text(std::string& text, const ReadMessage& message) {
    text += fmt::format("{:>12}", time_text(message));
    std::string_view separator = "  ";
    message.for_each([&](const ValueReader::Value& value, double number) {
        text += fmt::format("{}{} {:.10g}{}{}", separator, value.name, number,
                            value.unit.empty() ? "" : " ", value.unit);
        separator = ", ";
    });
    text += '\n';
}

void append_message_json(std::string& text, const ReadMessage& message) {
    nlohmann::ordered_json json;
    if (message.at) {
        json["t_us"] = whole_microseconds(*message.at);
    }
    json["protocol"] = message.protocol;
    message.for_each([&](const ValueReader::Value& value, double number) {
        json["values"][value.name] = number;
    });
    text += json.dump() + '\n';
}

void append_message_csv(std::string& text, const ReadMessage& message) {
    message.for_each([&](const ValueReader::Value& value, double number) {
        text +=
            fmt::format("{},{},{:.10g},{}\n", time_text(message), value.name, number, value.unit);
    });
}

}  // namespace

ValueDecoding::ValueDecoding(const ProtocolUse& use, const DecodeOutput& output)
    : use_(use),
      output_(output),
      reader_(use.protocol->make_value_reader(use.settings)),
      readings_(reader_->values().size()) {}

void ValueDecoding::heading() {
    output_.heading([](std::string& text) { text += "        t_us  values\n"; },
                    [](std::string& text) { text += "t_us,value,number,unit\n"; });
}

void ValueDecoding::feed_burst(std::size_t /*index*/, const Burst& burst) {
    for (std::size_t at = 0; at < burst.bytes.size(); ++at) {
        auto start = burst.start;
        if (start) {
            *start += use_.line.bytes_time(at);
        }
        feed_byte(burst.bytes[at], at < burst.damaged.size() && burst.damaged[at], start);
    }
}

void ValueDecoding::feed_byte(std::uint8_t byte, bool damaged, std::optional<Duration> start) {
    ++bytes_;
    if (damaged) {
        reader_->damaged_byte();
        return;
    }
    std::span<const std::uint8_t> bytes(&byte, 1);
    while (reader_->next(bytes, Instant(start.value_or(Duration::zero())), readings_)) {
        ++messages_;
        output_.results << in_format(
            output_.format, append_message_text, append_message_json, append_message_csv,
            ReadMessage{use_.protocol->name, start, reader_->values(), readings_});
    }
}

Tally ValueDecoding::tally() const {
    const auto rejected = reader_->rejected();
    return {.bytes = bytes_,
            .frames = messages_,
            .rejected = {rejected.begin(), rejected.end()},
            .skipped_bytes = reader_->skipped_bytes()};
}

void ValueDecoding::finish(const LogFacts& /*log*/) {
    output_.summary(
        [this](std::string& text) { append_summary_text(text, tally()); },
        [this](std::string& text) { append_summary_json(text, tally(), output_.input_name()); });
}

int ValueDecoding::status_of_nothing() const {
    return kExitFailed;
}

}  // namespace tribus
