#include "app/wire/decode_sensor.h"

#include "app/cli/exit_status.h"
#include "transports/codecs/ibus_sensor/ibus_sensor.h"

#include <utility>

namespace tribus {

SensorDecoding::SensorDecoding(SensorPrinter printer)
    : printer_(std::move(printer)),
      conversation_([this](const SensorExchange& exchange) { printer_.exchange(exchange); }),
      finder_([this](const ReceivedSensorFrame& received) { conversation_.take(received); }) {}

void SensorDecoding::feed_burst(std::size_t /*index*/, const Burst& burst) {
    finder_.feed(burst);
}

void SensorDecoding::finish(const LogFacts& /*facts*/) {
    conversation_.finish();
    printer_.summary(finder_.tally(), conversation_);
}

DecodedAmount SensorDecoding::amount() const {
    const SensorTally tally = finder_.tally();
    return {tally.frames.frames, tally.frames.bytes};
}

std::string_view SensorDecoding::protocol() const {
    return kSensorBusName;
}

int SensorDecoding::status_of_nothing() const {
    return kExitFailed;
}

}  // namespace tribus
