#include "app/wire/sensors/sensor_printer.h"

#include <ostream>
#include <utility>

#include "app/wire/sensors/sensor_text.h"

namespace tribus {

SensorPrinter::SensorPrinter(DecodeFormat format, RecordingKind input, SensorTypes types,
                             std::ostream& results, std::ostream& messages)
    : format_(format),
      input_(input),
      types_(std::move(types)),
      results_(results),
      messages_(messages) {}

void SensorPrinter::heading() {
    std::string text;
    if (format_ == DecodeFormat::text) {
        append_sensor_text_heading(text);
    } else if (format_ == DecodeFormat::csv) {
        append_sensor_csv_heading(text);
    }
    results_ << text;
}

void SensorPrinter::exchange(const SensorExchange& exchange) {
    std::string text;
    switch (format_) {
        case DecodeFormat::text:
            append_sensor_text(text, exchange, types_);
            break;
        case DecodeFormat::json:
            append_sensor_json(text, exchange, types_);
            break;
        case DecodeFormat::csv:
            append_sensor_csv(text, exchange, types_);
            break;
    }
    results_ << text;
}

void SensorPrinter::summary(const SensorTally& tally, const SensorConversation& conversation) {
    std::string text;
    if (format_ == DecodeFormat::json) {
        append_sensor_summary_json(text, tally, conversation, types_, recording_kind_name(input_));
    } else {
        append_sensor_summary_text(text, tally, conversation, types_);
    }
    (format_ == DecodeFormat::csv ? messages_ : results_) << text;
}

}  // namespace tribus
