#include "config/show/manual_sections.h"

#include <algorithm>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "config/keys/rows_ports.h"
#include "config/language/read_document.h"
#include "config/schema/notation.h"
#include "pipelines/rules/line_words.h"
#include "pipelines/rules/settings.h"
#include "transports/codecs/ibus_sensor/ibus_sensor.h"
#include "transports/links/can/can_link.h"
#include "transports/registry/registry.h"

namespace tribus {
namespace {

static_assert(kMostConfigurationBytes == 4UL * 1024UL * 1024UL, "the text below says so");
constexpr std::string_view kFileText = R"(
A configuration is a [TOML](https://toml.io) file of at most 4 MiB. Inputs, outputs, pipelines
and the rest are tables in it. A complete one:

```toml
[input.receiver]
protocol = "ibus"
device   = "/dev/ttyAMA5"

[output.servos]
protocol = "sbus"
device   = "/dev/ttyAMA3"

[pipeline.main]
from = "receiver"
to   = "servos"
```

`tribus check FILE` prints the configuration with every default, or all its mistakes with line and
column. A key that is not listed here is a mistake.

- `NAME` is a name that you choose: letters, digits, `_` and `-`.
- A table inside of another one may have a title of its own, `[pipeline.main.failsafe]`, or stand
  behind its key: `failsafe = { hold = "100ms" }`.
- A duration is text with a unit, `us`, `ms` or `s`: `"500us"`, `"7.7ms"`, `"2s"`.
- A pulse is a number of microseconds (us): 1000 and 2000 are the ends of a stick, 1500 is its
  centre. tribus calculates in steps of 0.125 us.
- A rate is text, microseconds of pulse a second: `"1000us/s"`.
- Channels have the numbers 1 to 18.
- A whole number may be written in hexadecimal: `0x300`.
- The path of a DBC file counts from the folder of the configuration.
- A named value is text such as `"battery.voltage"`; see [telemetry.md](telemetry.md).

Editors complete keys and show these texts if they have the schema: save `tribus schema >
tribus.schema.json` beside the configuration, and begin it with the line `#:schema
./tribus.schema.json`. The package has the schema as `/usr/share/tribus/tribus.schema.json`.)";

std::vector<Key> copy(std::span<const Key> keys) {
    return {keys.begin(), keys.end()};
}

std::string quoted_list(const Medium& medium, SettingScope way) {
    std::vector<std::string> names;
    for (const Protocol* protocol : protocols()) {
        if (carries(medium, *protocol) && protocol->goes(way)) {
            names.push_back(fmt::format("`{}`", protocol->name));
        }
    }
    return fmt::format("{}", fmt::join(names, ", "));
}

/// Whether an input, or output, can have the medium.
bool is_used(const Medium& medium, SettingScope way) {
    return std::ranges::any_of(protocols(), [&](const Protocol* protocol) {
        return carries(medium, *protocol) && protocol->goes(way);
    });
}

/// The help of a key that is the place of two media.
std::string_view joined_help(std::string_view one, const Medium& other) {
    static std::set<std::string> texts;
    return *texts.insert(fmt::format("{}; on {}: {}", one, other.name, other.place.help)).first;
}

/// Returns the keys of all inputs, or outputs, and those of each medium. A key of several media
/// stands there once.
std::vector<Key> port_keys(SettingScope way) {
    std::vector<Key> keys = copy(way == SettingScope::input ? input_keys() : output_keys());
    std::size_t place = 1;
    for (const Medium* medium : media()) {
        if (!is_used(*medium, way)) {
            continue;
        }
        Key key = place_key(*medium);
        key.setting.required = false;
        key.setting.absent = medium->place_absent;
        const auto same = std::ranges::find(keys, key.name(), &Key::name);
        if (same == keys.end()) {
            keys.insert(keys.begin() + std::ptrdiff_t(place++), key);
        } else {
            same->setting.help = joined_help(same->setting.help, *medium);
        }
        for (const Setting& setting : medium->settings) {
            if (setting.scope == SettingScope::both || setting.scope == way) {
                keys.push_back({setting});
            }
        }
    }
    if (way == SettingScope::output) {
        keys.push_back(key_rows::kForeignSenderKey);
    }
    return keys;
}

std::string place_text(SettingScope way) {
    std::vector<std::string> places;
    for (const Medium* medium : media()) {
        if (!is_used(*medium, way)) {
            continue;
        }
        places.push_back(fmt::format("`{}` on {} ({})", medium->place.key, medium->name,
                                     quoted_list(*medium, way)));
    }
    return fmt::format(
        "One key names the place: {}. Each protocol has [keys of its own](#keys-of-protocols) "
        "besides.",
        fmt::join(places, ", or "));
}

void add_ports(std::vector<ManualSection>& sections) {
    sections.push_back(
        {.title = "`[input.NAME]`",
         .text = "A source of channels: a receiver at a serial port, or a sender on CAN. It feeds "
                 "at least one pipeline. What decides that it is lost: "
                 "[failsafe.md](failsafe.md#when-an-input-is-lost).\n\n" +
                 place_text(SettingScope::input),
         .anchor = "input",
         .way = SettingScope::input,
         .keys = port_keys(SettingScope::input)});
    sections.push_back({.inner = true,
                        .title = "A rule of `failsafe_when`",
                        .text = "`channel` with at least one limit, or `all_zero` alone. With "
                                "several limits, one that is true is enough.",
                        .anchor = "failsafe_when",
                        .keys = copy(loss_rule_keys())});
    static_assert(kMostCanOutputs == 16, "the text below says so");
    sections.push_back(
        {.title = "`[output.NAME]`",
         .text = "Where channels go to: servos, a flight controller, a bus. It belongs to one "
                 "pipeline; an output that sends named values only needs none. An input and an "
                 "output may share a serial device if their line settings agree. A CAN interface "
                 "has at most 16 outputs, each with ids of its own.\n\n" +
                 place_text(SettingScope::output),
         .anchor = "output",
         .way = SettingScope::output,
         .keys = port_keys(SettingScope::output)});
}

std::string line_text(const Protocol& protocol) {
    if (protocol.shape == WireShape::can_frames) {
        return "on CAN";
    }
    if (!protocol.only_on.empty()) {
        return fmt::format("on {} only", protocol.only_on);
    }
    return fmt::format("on a serial line, {} baud 8{}{} unless `baud` says otherwise",
                       protocol.line.baud, protocol.line.parity == Parity::even ? 'E' : 'N',
                       protocol.line.stop_bits);
}

std::string protocol_text(const Protocol& protocol) {
    const std::string_view ways = !protocol.goes(SettingScope::input)    ? "Outputs only"
                                  : !protocol.goes(SettingScope::output) ? "Inputs only"
                                                                         : "Inputs and outputs";
    std::string text = fmt::format("{}. {}, {}.", protocol.description, ways, line_text(protocol));
    if (!protocol.goes(SettingScope::output)) {
        return text;
    }
    return fmt::format(
        "{} The `period` of an output is {}`\"{}\"` by default, and at least `\"{}\"` without "
        "`force`.",
        text, protocol.own_period == nullptr ? "" : "that of its messages, else ",
        format_duration(protocol.default_period), format_duration(protocol.least_period));
}

constexpr std::string_view kSignalText =
    "A number is a channel; a table says more. Exactly one of `channel`, `flag`, `fixed`, "
    "`counter`, `checksum` and `from` is in it. Examples: "
    "[can.md](can.md#your-own-messages-protocol--dbc).";

/// Keys inside of a tree that the protocol reads itself.
void add_trees(const Protocol& protocol, std::vector<ManualSection>& sections) {
    for (const Setting& setting : protocol.settings) {
        if (setting.inside.empty()) {
            continue;
        }
        std::vector<Key> keys;
        for (const Setting& inside : setting.inside) {
            keys.push_back({inside});
        }
        const bool signals = setting.key == "signals";
        sections.push_back(
            {.inner = true,
             .title = signals ? fmt::format("A signal of `{}`", protocol.name)
                              : fmt::format("`{}` of `{}`", setting.key, protocol.name),
             .text = signals ? std::string(kSignalText) : fmt::format("{}.", setting.help),
             .anchor = fmt::format("{}-{}", protocol.name, setting.key),
             .keys = std::move(keys)});
    }
}

void add_protocols(std::vector<ManualSection>& sections) {
    sections.push_back(
        {.title = "Keys of protocols",
         .text =
             "These keys stand in the tables of inputs and outputs with that `protocol`, beside "
             "the keys that all have. They are options of `tribus decode` and `tribus encode` "
             "too."});
    for (const Protocol* protocol : protocols()) {
        if (!protocol->has_channels()) {
            continue;
        }
        std::vector<Key> keys;
        for (const Setting& setting : protocol->settings) {
            keys.push_back({setting});
            if (!protocol->goes(SettingScope::input)) {
                keys.back().setting.scope = SettingScope::output;
            }
        }
        sections.push_back({.inner = true,
                            .title = fmt::format("`{}`", protocol->name),
                            .text = protocol_text(*protocol),
                            .anchor = std::string(protocol->name),
                            .keys = std::move(keys),
                            .shows_scope = true});
        add_trees(*protocol, sections);
    }
}

void add_pipelines(std::vector<ManualSection>& sections) {
    static_assert(kMostPipelineInputs == 16, "the text below says so");
    sections.push_back(
        {.title = "`[pipeline.NAME]`",
         .text = "Joins inputs, at most 16, to outputs. Several pipelines may read the same "
                 "input. More than one input: "
                 "[failsafe.md](failsafe.md#two-or-more-receivers).",
         .anchor = "pipeline",
         .keys = copy(pipeline_keys())});
    sections.push_back({.inner = true,
                        .title = "`handover`",
                        .anchor = "handover",
                        .keys = copy(handover_keys())});
    sections.push_back(
        {.title = "`[pipeline.NAME.channels]`, `[input.NAME.map]`",
         .text = "The map: output channel = what it is made of. Either the number of an input "
                 "channel, or a table with exactly one of `from`, `mix`, `fixed` and `line`. "
                 "`from` and `mix` can be shaped, in this order: `deadband`, `expo`, `reverse`, "
                 "`trim`, `slew`, `min` and `max`. Worked examples: "
                 "[channels.md](channels.md).\n\n"
                 "```toml\n"
                 "[pipeline.main.channels]\n"
                 "1  = 2\n"
                 "2  = { from = 1, reverse = true, trim = -12 }\n"
                 "5  = { mix = { 1 = 0.5, 2 = -0.5 } }\n"
                 "17 = { from = 9, above = 1700 }\n"
                 "```",
         .anchor = "channels",
         .keys = copy(channel_keys())});
    sections.push_back(
        {.title = "`[pipeline.NAME.failsafe]`",
         .text = "What outputs send while no input is healthy: "
                 "[failsafe.md](failsafe.md). **Set `preset` to what is safe on your machine.** "
                 "`[pipeline.NAME.failsafe.output.NAME]` has the same keys, but for `output`, and "
                 "counts for that output alone; a key that it does not have is as in "
                 "`[pipeline.NAME.failsafe]`.",
         .anchor = "failsafe",
         .keys = copy(failsafe_keys())});
    sections.push_back({.inner = true,
                        .title = "`release_when`",
                        .text = "`channel` with at least one limit. With several limits, one that "
                                "is true is enough.",
                        .anchor = "release_when",
                        .keys = copy(release_rule_keys())});
}

void add_stations(std::vector<ManualSection>& sections) {
    static_assert(kMostLines == 32, "the text below says so");
    sections.push_back(
        {.title = "`[gpio.NAME]`",
         .text = "A GPIO line, at most 32 of them: [failsafe.md](failsafe.md#gpio-lines). Roles "
                 "that are inputs: `force_failsafe`, `select`, `button`. `switch` requires "
                 "`output`, `channel` and at least one limit.",
         .anchor = "gpio",
         .keys = copy(line_keys())});
    static_assert(kMostSensors == 15, "a row says so");
    sections.push_back({.title = "`[sensor_bus.NAME]`",
                        .text = "An i.Bus sensor bus, as its sensors or as its receiver: "
                                "[sensor-bus.md](sensor-bus.md). A bus with the role `sensor` may "
                                "share the `device` of an input.",
                        .anchor = "sensor_bus",
                        .keys = copy(sensor_bus_keys())});
    sections.push_back({.inner = true,
                        .title = "`[[sensor_bus.NAME.sensor]]`",
                        .text = "The types and their units: "
                                "[sensor-bus.md](sensor-bus.md#types).",
                        .anchor = "sensor",
                        .keys = copy(sensor_keys())});
    sections.push_back({.title = "`[sensor_type.NAME]`",
                        .text = "A sensor type of your own; it replaces one of the same id or "
                                "name: [sensor-bus.md](sensor-bus.md#types).",
                        .anchor = "sensor_type",
                        .keys = copy(sensor_type_keys())});
    sections.push_back(
        {.title = "`[values.NAME]`",
         .text = "Named values: a constant, or the numbers in a CAN message, which is described "
                 "by `dbc` and `message` or by `dronecan`: [telemetry.md](telemetry.md).",
         .anchor = "values",
         .keys = copy(values_keys())});
    sections.push_back({.title = "`[dronecan.NAME]`",
                        .text = "The node that this program is on a CAN interface, one for each: "
                                "[dronecan.md](dronecan.md#the-node). Listening needs none.",
                        .anchor = "dronecan_node",
                        .keys = copy(dronecan_keys())});
    sections.push_back({.title = "`[recorder]`",
                        .text = "The flight recorder: [status.md](status.md#the-flight-recorder). "
                                "Without this table there is none.",
                        .anchor = "recorder",
                        .keys = copy(recorder_keys())});
}

}  // namespace

std::vector<ManualSection> manual_sections() {
    std::vector<ManualSection> sections;
    sections.push_back({.title = "The file", .text = std::string(kFileText)});
    sections.push_back({.title = "`[runtime]`",
                        .text =
                            "How the data thread runs. It does everything that is timed: it reads, "
                            "decodes, encodes and sends frames.",
                        .anchor = "runtime",
                        .keys = copy(runtime_keys())});
    add_ports(sections);
    add_protocols(sections);
    add_pipelines(sections);
    add_stations(sections);
    return sections;
}

}  // namespace tribus
