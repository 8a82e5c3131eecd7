#include "app/wire/dbc_command.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include <fmt/format.h>

#include "app/cli/exit_status.h"
#include "app/journal/print_error.h"
#include "core/can_frame.h"
#include "core/setting.h"
#include "transports/codecs/native_can/channels.h"
#include "transports/codecs/native_can/channels_dbc.h"
#include "transports/codecs/native_can/sensors.h"
#include "transports/codecs/native_can/sensors_dbc.h"
#include "transports/codecs/protocol.h"

namespace tribus {
namespace {

/// For the format that needs the fewest consecutive ids; each format checks its own limit.
constexpr std::int64_t kMostBaseId = kMostExtendedId - can_channels::kFdIndex;

struct DbcOptions {
    std::optional<std::int64_t> id;
    bool extended = false;
    bool sensors = false;
};

int print_dbc(const DbcOptions& options) {
    SettingValues settings;
    if (options.id) {
        settings.set("id", *options.id);
    }
    settings.set("extended", options.extended);
    const Protocol& protocol = options.sensors ? kSensorsProtocol : kCanProtocol;
    for (const SettingMistake& mistake : protocol.check(settings, SettingScope::output)) {
        print_error("--{}: {}\n", mistake.path.front(), mistake.text);
        return kExitWrongUse;
    }
    fmt::print("{}", options.sensors ? sensor_can_dbc(SensorCanFormat::from_settings(settings))
                                     : native_dbc(CanChannelsFormat::from_settings(settings)));
    return kExitFine;
}

}  // namespace

Command dbc_command() {
    auto options = std::make_shared<DbcOptions>();
    return {
        .name = "dbc",
        .help = "Print the native CAN formats as DBC files, for other CAN tools",
        .options = {{.name = "--id",
                     .value = &options->id,
                     .help = "Base id, as in the configuration",
                     .range = {{0, kMostBaseId}},
                     .value_name = "ID",
                     .default_text =
                         fmt::format("0x{:X}, of sensors 0x{:X}", can_channels::kDefaultBaseId,
                                     sensor_can::kDefaultBaseId)},
                    {.name = "--extended", .value = &options->extended, .help = "Ids of 29 bits"},
                    {.name = "--sensors",
                     .value = &options->sensors,
                     .help = "The readings of a sensor bus, protocol \"sensors\""}},
        .examples = {{"tribus dbc > native.dbc", "what an output of protocol can sends by default"},
                     {"tribus dbc --id 0x400", ""},
                     {"tribus dbc --sensors > sensors.dbc", ""}},
        .run = [options] { return print_dbc(*options); },
    };
}

}  // namespace tribus
