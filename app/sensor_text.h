#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/sensor_conversation.h"
#include "app/sensor_frame_finder.h"
#include "core/time.h"
#include "transports/codecs/ibus_sensor_types.h"

/// Exchanges of a sensor bus as lines.
namespace tribus {

/// One number of a value, as it is written.
struct WrittenField {
    std::string name;
    std::string unit;
    std::optional<std::string> number;  ///< with the decimals of its scale; none: not available
};

/// What an exchange says, in words and numbers that every format writes.
struct ExplainedExchange {
    std::string_view asked;   ///< "discover", "type", "value", "power_up"
    std::string_view answer;  ///< "reply", "miss", "free", "cut", "unasked", "none"
    std::string type;         ///< name, or "0x42" where the table has none; empty: never said
    const SensorFrame* data = nullptr;   ///< the frame that has data, if one has
    std::optional<std::uint64_t> raw{};  ///< of a value of at most 8 bytes
    std::vector<WrittenField> fields{};  ///< of a value whose type is known
};
ExplainedExchange explain(const SensorExchange& exchange, const SensorTypes& types);

/// `external_voltage`, or `0x42`.
std::string name_of_type(const SaidType& said, const SensorTypes& types);

/// The shortest, middle and longest time; the times need no order.
struct ResponseTimes {
    Duration least{};
    Duration median{};
    Duration most{};
};
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
