#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <memory>
#include <utility>

#include "transports/codecs/exbus/telemetry.h"
#include "transports/codecs/exbus/wire.h"

namespace tribus {
namespace {

using ExBusMistakes = std::vector<SettingMistake>;
using ExBusPath = std::vector<std::string>;

constexpr std::size_t kExMostSensors = 15;
constexpr std::int64_t kExMostDecimals = 3;
constexpr std::array<std::string_view, 3> kExForms{"decimal", "latitude", "longitude"};

constexpr std::array kExSensorKeys{
    Setting{.key = "value",
            .required = true,
            .scope = SettingScope::output,
            .help = "Name of a value",
            .example = "\"probes.1\""},
    Setting{.key = "label",
            .absent = "the end of the name of the value",
            .scope = SettingScope::output,
            .help = "What the transmitter calls it: 1 to 11 letters of ASCII",
            .example = "\"Battery\""},
    Setting{.key = "unit",
            .absent = "the unit of the value",
            .scope = SettingScope::output,
            .help = "The value is converted to it, and the transmitter shows it: 1 to 5 letters",
            .example = "\"V\""},
    Setting{.key = "decimals",
            .type = SettingType::integer,
            .fallback = "2",
            .most = kExMostDecimals,
            .scope = SettingScope::output,
            .help = "Digits behind the point; fewer where the number does not fit",
            .example = "1"},
    Setting{.key = "form",
            .type = SettingType::choice,
            .fallback = "\"decimal\"",
            .choices = kExForms,
            .scope = SettingScope::output,
            .help = "A number, or degrees of a position",
            .example = "\"latitude\""}};

constexpr std::array kExBusTelemetrySettings{
    kExBusBaudSetting,
    Setting{.key = "label",
            .fallback = "\"tribus\"",
            .scope = SettingScope::output,
            .help = "What the transmitter calls the device: 1 to 16 letters of ASCII",
            .example = "\"boat\""},
    Setting{.key = "number",
            .type = SettingType::integer,
            .fallback = "1",
            .most = 65535,
            .scope = SettingScope::output,
            .help = "Number of the device; no other at the receiver may have it",
            .example = "7"},
    Setting{.key = "sensors",
            .type = SettingType::tree,
            .required = true,
            .scope = SettingScope::output,
            .help = "Values by number, 1 to 15",
            .example = "{ 1 = { value = \"probes.1\", label = \"Battery\", unit = \"V\" } }",
            .inside = kExSensorKeys},
};

bool are_ex_letters(std::string_view text, std::size_t most) {
    return !text.empty() && text.size() <= most &&
           std::ranges::all_of(text, [](char c) { return c >= ' ' && c <= '~'; });
}

/// The end of the name of a value, as far as it fits.
std::string ex_label_of(std::string_view value) {
    const std::size_t dot = value.find_last_of('.');
    return std::string(value.substr(dot == std::string_view::npos ? 0 : dot + 1)
                           .substr(0, ExBusSensor::kMostLabel));
}

/// Reads the table `sensors`.
class ExBusSensorReader {
  public:
    explicit ExBusSensorReader(ExBusMistakes& mistakes) : mistakes_(mistakes) {}

    std::vector<ExBusSensor> read(const SettingTree& tree) {
        const auto* entries = tree.as<SettingTree::Table>();
        if (entries == nullptr || entries->empty()) {
            wrong({"sensors"},
                  "allowed: a table by number, such as { 1 = { value = \"probes.1\" } }");
            return {};
        }
        std::vector<ExBusSensor> sensors;
        for (const SettingEntry& entry : *entries) {
            ExBusSensor sensor;
            const ExBusPath path{"sensors", entry.key};
            if (!take_number(entry.key, sensor.number)) {
                wrong(path, "allowed: the numbers from 1 to 15");
            } else {
                take(entry.value, path, sensor);
                sensors.push_back(std::move(sensor));
            }
        }
        return sensors;
    }

  private:
    void wrong(ExBusPath path, std::string text) {
        mistakes_.push_back({std::move(path), std::move(text)});
    }
    static bool take_number(const std::string& key, std::uint8_t& number) {
        const char* const end = key.data() + key.size();
        const auto [at, error] = std::from_chars(key.data(), end, number);
        return error == std::errc() && at == end && number >= 1 && number <= kExMostSensors &&
               key.front() != '0';
    }

    void take(const SettingTree& tree, const ExBusPath& path, ExBusSensor& sensor) {
        const auto* entries = tree.as<SettingTree::Table>();
        for (const SettingEntry& entry : entries == nullptr ? SettingTree::Table{} : *entries) {
            ExBusPath inside = path;
            inside.push_back(entry.key);
            take_key(entry, inside, sensor);
        }
        if (sensor.value.empty()) {
            wrong(path,
                  "allowed: a table with value, the name of a value, and at will label, "
                  "unit, decimals, form");
        }
        if (sensor.label.empty()) {
            sensor.label = ex_label_of(sensor.value);
        }
        if (sensor.form != ExBusNumber::decimal && !sensor.unit.empty()) {
            wrong(path, "a position has no unit; leave unit out");
        }
    }
    void take_key(const SettingEntry& entry, const ExBusPath& path, ExBusSensor& sensor) {
        if (entry.key == "value") {
            take_text(entry.value, path, std::string::npos, "the name of a value", sensor.value);
        } else if (entry.key == "label") {
            take_text(entry.value, path, ExBusSensor::kMostLabel, "1 to 11 letters of ASCII",
                      sensor.label);
        } else if (entry.key == "unit") {
            take_text(entry.value, path, ExBusSensor::kMostUnit, "1 to 5 letters of ASCII",
                      sensor.unit);
        } else if (entry.key == "decimals") {
            const auto* number = entry.value.as<std::int64_t>();
            if (number == nullptr || *number < 0 || *number > kExMostDecimals) {
                wrong(path, "allowed: 0 to 3");
            } else {
                sensor.decimals = static_cast<int>(*number);
            }
        } else if (entry.key == "form") {
            const auto* word = entry.value.as<std::string>();
            const auto form = word == nullptr ? kExForms.end() : std::ranges::find(kExForms, *word);
            if (form == kExForms.end()) {
                wrong(path, R"(allowed: "decimal", "latitude", "longitude")");
            } else {
                sensor.form = static_cast<ExBusNumber>(form - kExForms.begin());
            }
        } else {
            wrong(path, "unknown; allowed: value, label, unit, decimals, form");
        }
    }
    void take_text(const SettingTree& tree, const ExBusPath& path, std::size_t most,
                   std::string_view allowed, std::string& taken) {
        const auto* text = tree.as<std::string>();
        if (text == nullptr || !are_ex_letters(*text, most)) {
            wrong(path, "allowed: " + std::string(allowed));
        } else {
            taken = *text;
        }
    }

    ExBusMistakes& mistakes_;
};

std::vector<SettingMistake> check_exbus_telemetry(const SettingValues& settings,
                                                  SettingScope /*scope*/) {
    ExBusMistakes mistakes;
    exbus_device(settings, mistakes);
    return mistakes;
}

std::vector<NamedUse> exbus_telemetry_values(const SettingValues& settings) {
    ExBusMistakes ignored;
    std::vector<NamedUse> uses;
    for (const ExBusSensor& sensor : exbus_device(settings, ignored).sensors) {
        uses.push_back({sensor.value,
                        {"sensors", std::to_string(sensor.number), "value"},
                        sensor.form == ExBusNumber::decimal ? sensor.unit : "deg"});
    }
    return uses;
}

bool exbus_telemetry_needs_no_pipeline(const SettingValues& /*settings*/) {
    return false;
}
bool exbus_receiver_asks(const SettingValues& /*settings*/) {
    return true;
}

AnyEncoder make_exbus_telemetry_encoder(const SettingValues& settings) {
    ExBusMistakes ignored;
    return std::make_unique<ExBusTelemetryEncoder>(exbus_device(settings, ignored));
}

}  // namespace

ExBusDevice exbus_device(const SettingValues& settings, std::vector<SettingMistake>& mistakes) {
    ExBusDevice device;
    if (const auto* label = settings.find_as<std::string>("label")) {
        device.name = *label;
        if (!are_ex_letters(device.name, ExBusDevice::kMostName)) {
            mistakes.push_back({{"label"}, "allowed: 1 to 16 letters of ASCII"});
        }
    }
    if (const auto* number = settings.find_as<std::int64_t>("number")) {
        device.number = static_cast<std::uint16_t>(*number);
    }
    if (const auto* sensors = settings.find_as<SettingTree>("sensors")) {
        device.sensors = ExBusSensorReader(mistakes).read(*sensors);
    }
    return device;
}

const Protocol kExBusTelemetryProtocol{
    .name = "exbus-telemetry",
    .title = "EX Bus telemetry",
    .description = "Named values to a Jeti receiver that asks for them on EX Bus",
    .line = kExBusLine,
    .settings = kExBusTelemetrySettings,
    .longest_frame = 34,
    // Each request is answered at once; without one nothing is sent.
    .default_period = std::chrono::seconds(1),
    .least_period = std::chrono::milliseconds(20),
    // A frame has only values that are fresh, independent of channels.
    .signals_failsafe = always_signals_failsafe,
    .check = check_exbus_telemetry,
    .value_names = exbus_telemetry_values,
    .needs_pipeline = exbus_telemetry_needs_no_pipeline,
    .is_timed_by_receiver = exbus_receiver_asks,
    .make_encoder = make_exbus_telemetry_encoder,
};

}  // namespace tribus
