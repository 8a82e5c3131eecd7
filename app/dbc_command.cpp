#include "app/dbc_command.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "app/exit_status.h"
#include "core/can_frame.h"
#include "core/setting.h"
#include "transports/codecs/can_channels.h"
#include "transports/codecs/can_channels_dbc.h"
#include "transports/codecs/protocol.h"
#include "transports/codecs/sensor_can.h"
#include "transports/codecs/sensor_can_dbc.h"

namespace tribus {
namespace {

/// Of the format that needs the fewest ids in a row; each checks its own.
constexpr std::int64_t kMostBaseId = kMostExtendedId - can_channels::kFdIndex;

struct Options {
    std::optional<std::int64_t> id;
    bool extended = false;
    bool sensors = false;
};

int print_dbc(const Options& options) {
    SettingValues settings;
    if (options.id) {
        settings.set("id", *options.id);
    }
    settings.set("extended", options.extended);
    const Protocol& protocol = options.sensors ? kSensorsProtocol : kCanProtocol;
    for (const SettingMistake& mistake : protocol.check(settings, SettingScope::output)) {
        fmt::print(stderr, "--{}: {}\n", mistake.path.front(), mistake.text);
        return kExitWrongUse;
    }
    fmt::print("{}", options.sensors ? sensor_can_dbc(SensorCanFormat::from_settings(settings))
                                     : native_dbc(CanChannelsFormat::from_settings(settings)));
    return kExitFine;
}

}  // namespace

void add_dbc_command(CLI::App& app, int& status) {
    auto* command = app.add_subcommand(
        "dbc", "Print the native CAN formats as DBC files, for other tools on the bus");
    auto options = std::make_shared<Options>();
    command->add_option("--id", options->id, "Base id, as in the configuration")
        ->check(CLI::Range(std::int64_t{0}, kMostBaseId))
        ->default_str(fmt::format("0x{:X}, of sensors 0x{:X}", can_channels::kDefaultBaseId,
                                  sensor_can::kDefaultBaseId));
    command->add_flag("--extended", options->extended, "Ids of 29 bits");
    command->add_flag("--sensors", options->sensors,
                      "The readings of a sensor bus, protocol \"sensors\"");
    command->callback([options, &status] { status = print_dbc(*options); });
}

}  // namespace tribus
