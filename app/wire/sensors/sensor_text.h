#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/wire/sensors/sensor_conversation.h"
#include "app/wire/sensors/sensor_frame_finder.h"
#include "core/time.h"
#include "transports/codecs/ibus_sensor/types.h"

/// Exchanges of a sensor bus as lines of text, CSV or JSON.
namespace tribus {

/// One number of a value, as printed.
struct WrittenField {
    std::string name;
    std::string unit;
    std::optional<std::string> number;  ///< with the decimals of its scale; empty: not available
};

/// An exchange in the words and numbers that all formats print.
struct ExplainedExchange {
    std::string_view asked;   ///< "discover", "type", "value", "power_up"
    std::string_view answer;  ///< "reply", "miss", "free", "cut", "unasked", "none"
    std::string type;         ///< name, or "0x42" if the table has none; empty: not known yet
    const SensorFrame* data = nullptr;   ///< the frame with data; null if none has
    std::optional<std::uint64_t> raw{};  ///< of a value of at most 8 bytes
    std::vector<WrittenField> fields{};  ///< of a value of a known type
};
/// Refers to `exchange`, which must outlive the result.
ExplainedExchange explain(const SensorExchange& exchange, const SensorTypes& types);

/// `external_voltage`; `0x42` for an unknown type.
std::string name_of_type(const ReportedType& reported, const SensorTypes& types);

/// The shortest, median and longest time. The input need not be sorted.
struct ResponseTimes {
    Duration least{};
    Duration median{};
    Duration most{};
};
/// Nothing without times.
std::optional<ResponseTimes> summary_of(std::vector<Duration> times);

void append_sensor_text_heading(std::string& text);
void append_sensor_text(std::string& text, const SensorExchange& exchange,
                        const SensorTypes& types);
void append_sensor_summary_text(std::string& text, const SensorTally& tally,
                                const SensorConversation& conversation, const SensorTypes& types);
void append_sensor_csv_heading(std::string& text);
void append_sensor_csv(std::string& text, const SensorExchange& exchange, const SensorTypes& types);
void append_sensor_json(std::string& text, const SensorExchange& exchange,
                        const SensorTypes& types);
void append_sensor_summary_json(std::string& text, const SensorTally& tally,
                                const SensorConversation& conversation, const SensorTypes& types,
                                std::string_view input);

}  // namespace tribus
