#include "app/wire/decode_sensor.h"

#include <utility>

#include "app/cli/exit_status.h"
#include "app/wire/sensors/sensor_text.h"
#include "transports/codecs/ibus_sensor/ibus_sensor.h"

namespace tribus {

SensorDecoding::SensorDecoding(SensorTypes types, const DecodeOutput& output)
    : types_(std::move(types)),
      output_(output),
      conversation_([this](const SensorExchange& exchange) {
          output_.results << in_format(output_.format, append_sensor_text, append_sensor_json,
                                       append_sensor_csv, exchange, types_);
      }),
      finder_([this](const ReceivedSensorFrame& received) { conversation_.take(received); }) {}

void SensorDecoding::heading() {
    output_.heading(append_sensor_text_heading, append_sensor_csv_heading);
}

void SensorDecoding::feed_burst(std::size_t index, const Burst& burst) {
    finder_.feed_burst(index, burst);
}

void SensorDecoding::finish(const LogFacts& /*log*/) {
    conversation_.finish();
    output_.summary(
        [this](std::string& text) {
            append_sensor_summary_text(text, finder_.tally(), conversation_, types_);
        },
        [this](std::string& text) {
            append_sensor_summary_json(text, finder_.tally(), conversation_, types_,
                                       output_.input_name());
        });
}

DecodedAmount SensorDecoding::amount() const {
    return amount_of(finder_.tally().frames);
}

std::string_view SensorDecoding::protocol() const {
    return kSensorBusName;
}

int SensorDecoding::status_of_nothing() const {
    return kExitFailed;
}

}  // namespace tribus
