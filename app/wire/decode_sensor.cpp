#include "app/wire/decode_sensor.h"

#include <ostream>

#include "app/cli/exit_status.h"
#include "app/wire/fitting_protocols.h"
#include "app/wire/sensors/sensor_conversation.h"
#include "app/wire/sensors/sensor_frame_finder.h"
#include "transports/codecs/ibus_sensor/ibus_sensor.h"

namespace tribus {

int decode_sensor_recording(const Recording& recording, SensorPrinter& printer,
                            std::ostream& messages) {
    printer.heading();
    SensorConversation conversation(
        [&](const SensorExchange& exchange) { printer.exchange(exchange); });
    SensorFrameFinder finder(
        [&](const ReceivedSensorFrame& received) { conversation.take(received); });
    for (const Burst& burst : recording.bursts) {
        finder.feed(burst);
    }
    conversation.finish();
    const SensorTally tally = finder.tally();
    printer.summary(tally, conversation);
    if (tally.frames.frames > 0 || tally.frames.bytes == 0) {
        return kExitFine;
    }
    messages << no_frame_text(recording, kSensorBusName);
    return kExitFailed;
}

int decode_sensor_stream(const std::function<std::string()>& read, SensorPrinter& printer,
                         std::ostream& results) {
    printer.heading();
    SensorConversation conversation(
        [&](const SensorExchange& exchange) { printer.exchange(exchange); });
    SensorFrameFinder finder(
        [&](const ReceivedSensorFrame& received) { conversation.take(received); });
    while (results.good()) {
        const std::string bytes = read();
        if (bytes.empty()) {
            break;
        }
        finder.feed({.start = std::nullopt, .bytes = {bytes.begin(), bytes.end()}, .damaged = {}});
        results.flush();
    }
    conversation.finish();
    printer.summary(finder.tally(), conversation);
    return kExitFine;
}

}  // namespace tribus
