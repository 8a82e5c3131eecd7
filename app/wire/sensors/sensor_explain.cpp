#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "app/wire/sensors/sensor_text.h"

namespace tribus {
namespace {

std::string_view command_text(SensorCommand command) {
    switch (command) {
        case SensorCommand::discover:
            return "discover";
        case SensorCommand::type:
            return "type";
        case SensorCommand::value:
            return "value";
        case SensorCommand::power_up:
            return "power_up";
    }
    return "";
}

std::string_view outcome_text(SensorOutcome outcome) {
    switch (outcome) {
        case SensorOutcome::answered:
            return "reply";
        case SensorOutcome::missed:
            return "miss";
        case SensorOutcome::free:
            return "free";
        case SensorOutcome::cut:
            return "cut";
        case SensorOutcome::unasked:
            return "unasked";
        case SensorOutcome::power_up:
            return "none";
    }
    return "";
}

/// The decimals of the scale; four if it is no decimal fraction.
int decimals_of(double scale) {
    constexpr int kMost = 7;
    constexpr int kEnough = 4;
    double stretched = std::abs(scale);
    for (int decimals = 0; decimals <= kMost; ++decimals) {
        if (std::abs(stretched - std::round(stretched)) < 1e-9 && stretched > 0.5) {
            return decimals;
        }
        stretched *= 10;
    }
    return kEnough;
}

std::vector<WrittenField> written_fields(const SensorType& type, const SensorFrame& frame) {
    std::vector<WrittenField> fields;
    for (const SensorField& field : type.fields) {
        WrittenField written{.name = field.name, .unit = field.unit, .number = {}};
        const auto raw = raw_in(field, frame.payload());
        const auto number = raw ? number_of(field, *raw) : std::nullopt;
        if (number) {
            written.number = fmt::format("{:.{}f}", *number, decimals_of(field.scale));
        }
        fields.push_back(std::move(written));
    }
    return fields;
}

}  // namespace

std::string name_of_type(const ReportedType& reported, const SensorTypes& types) {
    const SensorType* const type = types.find(reported.id);
    return type == nullptr ? fmt::format("0x{:02X}", reported.id) : type->name;
}

ExplainedExchange explain(const SensorExchange& exchange, const SensorTypes& types) {
    ExplainedExchange explained{.asked = command_text(exchange.asked.frame.command),
                                .answer = outcome_text(exchange.outcome),
                                .type = {}};
    if (exchange.type) {
        explained.type = name_of_type(*exchange.type, types);
    }
    const SensorFrame& last = exchange.answer ? exchange.answer->frame : exchange.asked.frame;
    if (last.is_request()) {
        return explained;
    }
    explained.data = &last;
    if (last.command != SensorCommand::value) {
        return explained;
    }
    explained.raw = plain_raw_in(last.payload());
    const SensorType* const type = exchange.type ? types.find(exchange.type->id) : nullptr;
    if (type != nullptr) {
        explained.fields = written_fields(with_size(*type, last.data_size), last);
    }
    return explained;
}

std::optional<ResponseTimes> summary_of(std::vector<Duration> times) {
    if (times.empty()) {
        return std::nullopt;
    }
    std::ranges::sort(times);
    return ResponseTimes{
        .least = times.front(), .median = times[times.size() / 2], .most = times.back()};
}

}  // namespace tribus
