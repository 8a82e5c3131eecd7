#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "transports/codecs/crsf/telemetry.h"
#include "transports/codecs/crsf/telemetry_numbers.h"
#include "transports/codecs/crsf/telemetry_reader.h"
#include "transports/codecs/crsf/wire.h"

namespace tribus {
namespace {

using Path = std::vector<std::string>;
using TelemetryMistakes = std::vector<SettingMistake>;

constexpr Setting value_key(std::string_view key, std::string_view help, std::string_view example) {
    return {.key = key,
            .type = SettingType::text,
            .scope = SettingScope::output,
            .help = help,
            .example = example};
}

constexpr Setting tree_key(std::string_view key, std::string_view help, std::string_view example,
                           std::span<const Setting> inside = {}) {
    return {.key = key,
            .type = SettingType::tree,
            .scope = SettingScope::output,
            .help = help,
            .example = example,
            .inside = inside};
}

constexpr std::array kBatteryKeys{value_key("voltage", "Value in V", "\"probes.1\""),
                                  value_key("current", "Value in A", "\"probes.2\""),
                                  value_key("consumed", "Value in mAh", "\"probes.3\""),
                                  value_key("remaining", "Value in %", "\"probes.4\"")};
constexpr std::array kGpsKeys{
    value_key("latitude", "Value in degrees, north positive", "\"probes.5\""),
    value_key("longitude", "Value in degrees, east positive", "\"probes.6\""),
    value_key("speed", "Value in km/h", "\"probes.7\""),
    value_key("heading", "Value in degrees, 0 to 360", "\"probes.8\""),
    value_key("altitude", "Value in m", "\"probes.9\""),
    value_key("satellites", "Value: how many", "\"probes.10\"")};
constexpr std::array kAttitudeKeys{value_key("pitch", "Value in degrees", "\"probes.11\""),
                                   value_key("roll", "Value in degrees", "\"probes.12\""),
                                   value_key("yaw", "Value in degrees", "\"probes.13\"")};
constexpr std::array kFlightModeKeys{
    value_key("value", "Value that is the number of the name, from 0", "\"probes.4\""),
    tree_key("names", "The names, each of 1 to 14 letters", "[\"MANUAL\", \"AUTO\"]")};

constexpr std::array kTelemetrySettings{
    baud_setting("420000", "115200", 5.25e6),
    tree_key("battery", "Values of a battery", "{ voltage = \"probes.1\" }", kBatteryKeys),
    tree_key("gps", "Values of a position; latitude and longitude together",
             "{ latitude = \"probes.5\", longitude = \"probes.6\" }", kGpsKeys),
    tree_key("attitude", "Values of an attitude", "{ roll = \"probes.12\" }", kAttitudeKeys),
    value_key("vario", "Value of the vertical speed, in m/s", "\"probes.14\""),
    value_key("airspeed", "Value in km/h", "\"probes.7\""),
    tree_key("rpm", "Values in 1/min by number, 1 to 19", "{ 1 = \"probes.15\" }"),
    tree_key("temperature", "Values in degC by number, 1 to 20", "{ 1 = \"probes.1\" }"),
    tree_key("cells", "Values of cells in V by number, 1 to 29",
             "{ 1 = \"probes.1\", 2 = \"probes.2\" }"),
    tree_key("flight_mode", "A text for each number of a value",
             "{ value = \"probes.4\", names = [\"MANUAL\", \"AUTO\"] }", kFlightModeKeys),
};

CrsfTelemetryField field_of(const TelemetryNumber& number, std::string value, Path path) {
    return {.value = std::move(value),
            .path = std::move(path),
            .unit = number.unit,
            .scale = number.scale,
            .offset = number.offset,
            .bytes = number.bytes,
            .is_signed = number.is_signed,
            .is_turn = number.forming == TelemetryForming::turn};
}

/// Reads the keys into frames.
class TelemetryReader {
  public:
    TelemetryReader(const SettingValues& settings, TelemetryMistakes& mistakes)
        : settings_(settings), mistakes_(mistakes) {}

    std::vector<CrsfTelemetryFrame> read() {
        for (const TelemetryMessage& message : kTelemetryMessages) {
            switch (message.form) {
                case TelemetryForm::table:
                    table(message);
                    break;
                case TelemetryForm::single:
                    single(message);
                    break;
                case TelemetryForm::numbered:
                    numbered(message);
                    break;
            }
        }
        flight_mode();
        if (frames_.empty() && mistakes_.empty()) {
            wrong({},
                  "it has nothing to send; allowed: at least one of battery, gps, attitude, "
                  "vario, airspeed, rpm, temperature, cells, flight_mode");
        }
        return std::move(frames_);
    }

  private:
    void wrong(Path path, std::string text) {
        mistakes_.push_back({std::move(path), std::move(text)});
    }
    const SettingTree* tree(std::string_view key) const {
        return settings_.find_as<SettingTree>(key);
    }

    /// The name of a value, or nothing and a mistake.
    std::optional<std::string> name_in(const SettingTree& tree, const Path& path) {
        const auto* name = tree.as<std::string>();
        if (name == nullptr || name->empty()) {
            wrong(path, "allowed: the name of a value, such as \"probes.1\"");
            return std::nullopt;
        }
        return *name;
    }

    void table(const TelemetryMessage& message) {
        const auto numbers = message.numbers;
        const SettingTree* content = tree(message.key);
        if (content == nullptr) {
            return;
        }
        const std::string key(message.key);
        const auto* entries = content->as<SettingTree::Table>();
        if (entries == nullptr || entries->empty()) {
            wrong({key}, "allowed: a table with " + names_of(numbers));
            return;
        }
        CrsfTelemetryFrame frame{.type = message.type};
        for (const TelemetryNumber& number : numbers) {
            frame.fields.push_back(field_of(number, {}, {}));
        }
        for (const SettingEntry& entry : *entries) {
            const Path path{key, entry.key};
            const auto known = std::ranges::find(numbers, entry.key, &TelemetryNumber::key);
            if (known == numbers.end()) {
                wrong(path, "unknown; allowed: " + names_of(numbers));
            } else if (auto name = name_in(entry.value, path)) {
                auto& field = frame.fields[static_cast<std::size_t>(known - numbers.begin())];
                field.value = std::move(*name);
                field.path = path;
            }
        }
        if (message.type == kGpsType &&
            (frame.fields[0].value.empty() || frame.fields[1].value.empty())) {
            wrong({key}, "latitude and longitude are needed, both");
        }
        frames_.push_back(std::move(frame));
    }
    static std::string names_of(std::span<const TelemetryNumber> numbers) {
        std::string names;
        for (const TelemetryNumber& number : numbers) {
            names += (names.empty() ? "" : ", ") + std::string(number.key);
        }
        return names;
    }

    void single(const TelemetryMessage& message) {
        const TelemetryNumber& number = message.numbers.front();
        const auto* name = settings_.find_as<std::string>(number.key);
        if (name != nullptr) {
            frames_.push_back({.type = message.type,
                               .prefix = {},
                               .fields = {field_of(number, *name, {std::string(number.key)})}});
        }
    }

    void numbered(const TelemetryMessage& message) {
        const TelemetryNumber& number = message.numbers.front();
        const std::size_t most = message.most;
        const SettingTree* content = tree(number.key);
        if (content == nullptr) {
            return;
        }
        const Path path{std::string(number.key)};
        const auto* entries = content->as<SettingTree::Table>();
        CrsfTelemetryFrame frame{.type = message.type, .prefix = {kTelemetrySource}};
        if (entries != nullptr && entries->size() <= most) {
            frame.fields.resize(entries->size(), field_of(number, {}, {}));
        }
        for (const SettingEntry& entry : entries == nullptr ? SettingTree::Table{} : *entries) {
            const std::size_t place = std::strtoul(entry.key.c_str(), nullptr, 10);
            const Path inside{path[0], entry.key};
            auto name = name_in(entry.value, inside);
            if (place < 1 || place > frame.fields.size() || std::to_string(place) != entry.key) {
                wrong(inside, "allowed: the numbers from 1 on, at most " + std::to_string(most) +
                                  ", without a gap");
            } else if (name) {
                frame.fields[place - 1].value = std::move(*name);
                frame.fields[place - 1].path = inside;
            }
        }
        if (frame.fields.empty()) {
            wrong(path, "allowed: a table of 1 to " + std::to_string(most) +
                            " values by number, such as { 1 = \"probes.1\" }");
            return;
        }
        frames_.push_back(std::move(frame));
    }

    void flight_mode() {
        constexpr std::string_view kKey = "flight_mode";
        const SettingTree* content = tree(kKey);
        const auto* entries = content == nullptr ? nullptr : content->as<SettingTree::Table>();
        if (content == nullptr) {
            return;
        }
        CrsfTelemetryFrame frame{.type = 0x21};
        for (const SettingEntry& entry : entries == nullptr ? SettingTree::Table{} : *entries) {
            const Path path{std::string(kKey), entry.key};
            if (entry.key == "value") {
                if (auto name = name_in(entry.value, path)) {
                    frame.fields.push_back(field_of({}, std::move(*name), path));
                }
            } else if (entry.key == "names") {
                frame.texts = texts_in(entry.value, path);
            } else {
                wrong(path, "unknown; allowed: value, names");
            }
        }
        if (frame.fields.size() != 1 || frame.texts.empty()) {
            wrong({std::string(kKey)}, "allowed: a table with value and names, both");
            return;
        }
        frames_.push_back(std::move(frame));
    }

    std::vector<std::string> texts_in(const SettingTree& tree, const Path& path) {
        constexpr std::size_t kMostLetters = 14;
        const auto* items = tree.as<SettingTree::List>();
        std::vector<std::string> texts;
        for (const SettingTree& item : items == nullptr ? SettingTree::List{} : *items) {
            const auto* text = item.as<std::string>();
            const bool fits =
                text != nullptr && !text->empty() && text->size() <= kMostLetters &&
                std::ranges::all_of(*text, [](char c) { return c >= ' ' && c <= '~'; });
            if (!fits) {
                wrong(path, "allowed: a list of names, each of 1 to 14 letters of ASCII");
                return {};
            }
            texts.push_back(*text);
        }
        return texts;
    }

    const SettingValues& settings_;
    TelemetryMistakes& mistakes_;
    std::vector<CrsfTelemetryFrame> frames_;
};

std::vector<SettingMistake> check_telemetry(const SettingValues& settings, SettingScope scope) {
    TelemetryMistakes mistakes;
    if (scope == SettingScope::input) {
        return mistakes;
    }
    crsf_telemetry_frames(settings, mistakes);
    return mistakes;
}

std::vector<NamedUse> telemetry_values(const SettingValues& settings) {
    TelemetryMistakes ignored;
    std::vector<NamedUse> uses;
    for (const CrsfTelemetryFrame& frame : crsf_telemetry_frames(settings, ignored)) {
        for (const CrsfTelemetryField& field : frame.fields) {
            if (!field.value.empty()) {
                uses.push_back({field.value, field.path, std::string(field.unit)});
            }
        }
    }
    return uses;
}

bool telemetry_needs_no_pipeline(const SettingValues& /*settings*/) {
    return false;
}

AnyEncoder make_telemetry_encoder(const SettingValues& settings) {
    TelemetryMistakes ignored;
    return std::make_unique<CrsfTelemetryEncoder>(crsf_telemetry_frames(settings, ignored));
}

std::unique_ptr<ByteValueReader> make_telemetry_reader(const SettingValues& /*settings*/) {
    return std::make_unique<CrsfTelemetryReader>();
}

}  // namespace

std::vector<CrsfTelemetryFrame> crsf_telemetry_frames(const SettingValues& settings,
                                                      std::vector<SettingMistake>& mistakes) {
    return TelemetryReader(settings, mistakes).read();
}

// ExpressLRS takes as many frames as its telemetry ratio allows and drops the others; Betaflight
// sends about ten a second.
const Protocol kCrsfTelemetryProtocol{
    .name = "crsf-telemetry",
    .title = "CRSF telemetry",
    .description =
        "Named values to a CRSF receiver, which shows them on the handset; or from a "
        "flight controller or a transmitter module",
    .line = {.baud = 420000, .parity = Parity::none, .stop_bits = 1},
    .settings = kTelemetrySettings,
    .longest_frame = crsf_wire::kUncounted + crsf_wire::kMostLength,
    .default_period = std::chrono::milliseconds(100),
    .least_period = std::chrono::milliseconds(20),
    // A frame has only values that are fresh, independent of channels.
    .signals_failsafe = always_signals_failsafe,
    .check = check_telemetry,
    .value_names = telemetry_values,
    .needs_pipeline = telemetry_needs_no_pipeline,
    .make_encoder = make_telemetry_encoder,
    .make_value_reader = make_telemetry_reader,
};

}  // namespace tribus
