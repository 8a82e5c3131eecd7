#include "transports/codecs/native_can/sensors.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "core/rounding.h"

namespace tribus {

using namespace sensor_can;

namespace {

constexpr std::array kSensorSettings{
    Setting{.key = "sensor_bus",
            .type = SettingType::text,
            .required = true,
            .help = "Sensor bus whose readings are sent: NAME of `[sensor_bus.NAME]`",
            .example = "\"probes\""},
    Setting{.key = "id",
            .type = SettingType::integer,
            .fallback = "800",
            .least = 0,
            .most = kMostExtendedId - (kMostSensors - 1),
            .help = "First of 15 CAN ids in a row, one for each address; 800 is 0x320",
            .example = "0x400"},
    Setting{.key = "extended",
            .type = SettingType::boolean,
            .fallback = "false",
            .help = "`true`: ids of 29 bits",
            .example = "true"},
};
static_assert(sensor_can::kDefaultBaseId == 800);

std::vector<SettingMistake> check(const SettingValues& settings, SettingScope scope) {
    std::vector<SettingMistake> mistakes;
    if (scope == SettingScope::input) {
        mistakes.push_back({{"sensor_bus"},
                            "protocol \"sensors\" only sends; allowed: in an output; "
                            "[values.NAME] reads such messages with the DBC file that "
                            "\"tribus dbc --sensors\" prints"});
    }
    const SensorCanFormat format = SensorCanFormat::from_settings(settings);
    const std::uint32_t most = (format.extended ? kMostExtendedId : kMostStandardId) -
                               static_cast<std::uint32_t>(kMostSensors - 1);
    if (format.base_id > most) {
        mistakes.push_back(
            {{"id"},
             std::to_string(format.base_id) + " is too high for 15 ids in a row of " +
                 (format.extended ? "29" : "11") + " bits; allowed is 0 to " +
                 std::to_string(most) + (format.extended ? "" : ", or more with extended = true")});
    }
    return mistakes;
}

/// Name of the raw value at an address from 1.
std::string value_name(const std::string& sensor_bus, std::size_t address) {
    return sensor_bus + "." + std::to_string(address) + ".raw";
}

/// A bus has the values of all its addresses or none, so the first one represents them.
std::vector<NamedUse> value_names(const SettingValues& settings) {
    return {{value_name(SensorCanFormat::from_settings(settings).sensor_bus, 1), {"sensor_bus"}}};
}

bool never_needs_pipeline(const SettingValues& /*settings*/) {
    return false;
}

AnyEncoder make_sensor_encoder(const SettingValues& settings) {
    return std::make_unique<SensorCanEncoder>(SensorCanFormat::from_settings(settings));
}

/// The 32 bits of a signed or unsigned raw value. Other values are limited to the nearest.
std::uint32_t raw_bits(double raw) {
    constexpr double kLeast = std::numeric_limits<std::int32_t>::min();
    constexpr double kMost = std::numeric_limits<std::uint32_t>::max();
    return std::isnan(raw)
               ? 0
               : static_cast<std::uint32_t>(nearest_whole(std::clamp(raw, kLeast, kMost)));
}

std::uint16_t age_bits(Duration age) {
    constexpr std::int64_t kMost = std::numeric_limits<std::uint16_t>::max();
    const auto milliseconds = std::chrono::duration_cast<std::chrono::milliseconds>(age).count();
    return static_cast<std::uint16_t>(std::clamp<std::int64_t>(milliseconds, 0, kMost));
}

// All 15 frames take 8 ms of a bus at 250 kbit/s.
constexpr Duration kLeastPeriod = std::chrono::milliseconds(10);

}  // namespace

SensorCanFormat SensorCanFormat::from_settings(const SettingValues& settings) {
    return {.sensor_bus = settings.get_or<std::string>("sensor_bus", ""),
            .base_id = static_cast<std::uint32_t>(
                settings.get_or<std::int64_t>("id", std::int64_t{sensor_can::kDefaultBaseId})),
            .extended = settings.get_or<bool>("extended", false)};
}

SensorCanEncoder::SensorCanEncoder(SensorCanFormat format) : format_(std::move(format)) {
    for (std::size_t i = 0; i < kMostSensors; ++i) {
        sent_[i] = {.id = format_.base_id + static_cast<std::uint32_t>(i),
                    .extended = format_.extended};
    }
}

void SensorCanEncoder::use(const ValueBoard& board) {
    board_ = &board;
    for (std::size_t i = 0; i < kMostSensors; ++i) {
        indexes_[i] = board.find(value_name(format_.sensor_bus, i + 1));
    }
}

void SensorCanEncoder::continue_from(const Encoder& before) {
    const auto* same = dynamic_cast<const SensorCanEncoder*>(&before);
    if (same != nullptr) {
        counters_ = same->counters_;
    }
}

std::size_t SensorCanEncoder::write(const ChannelFrame& /*snapshot*/,
                                    std::span<CanFrame, kMostSnapshotFrames> frames, Instant now) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < kMostSensors; ++i) {
        if (indexes_[i] && board_->ever(*indexes_[i])) {
            frames[count++] = make_frame(i, now);
        }
    }
    return count;
}

CanFrame SensorCanEncoder::make_frame(std::size_t i, Instant now) {
    const std::size_t index = *indexes_[i];
    const bool fresh = board_->fresh(index, now).has_value();
    const std::uint16_t age = age_bits(board_->age(index, now));
    const std::uint32_t raw = raw_bits(board_->latest(index));
    CanFrame frame{.id = sent_[i].id, .extended = format_.extended, .length = kMostClassicBytes};
    frame.data[kTypeByte] = board_->tag(index);
    frame.data[kStateByte] = static_cast<std::uint8_t>(unsigned{counters_[i]} << kCounterShift |
                                                       (fresh ? kAvailableBit : 0U));
    frame.data[kAgeByte] = static_cast<std::uint8_t>(age);
    frame.data[kAgeByte + 1] = static_cast<std::uint8_t>(age >> 8U);
    for (unsigned byte = 0; byte < sizeof raw; ++byte) {
        frame.data[kRawByte + byte] = static_cast<std::uint8_t>(raw >> (8 * byte));
    }
    counters_[i] = counters_[i] == kMostCounter ? 0 : static_cast<std::uint8_t>(counters_[i] + 1);
    return frame;
}

const Protocol kSensorsProtocol{
    .name = "sensors",
    .title = "sensors on CAN",
    .description = "The readings of a sensor bus, a CAN frame for each address",
    .shape = WireShape::can_frames,
    .line = {},
    .settings = kSensorSettings,
    .default_period = kDefaultPeriod,
    .least_period = kLeastPeriod,
    // The frames themselves say which readings are fresh, independent of channels.
    .signals_failsafe = always_signals_failsafe,
    .check = check,
    .value_names = value_names,
    .needs_pipeline = never_needs_pipeline,
    .make_encoder = make_sensor_encoder,
};

}  // namespace tribus
