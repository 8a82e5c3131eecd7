#include "app/dbc_command.h"

#include <cstdint>
#include <memory>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "app/exit_status.h"
#include "core/can_frame.h"
#include "core/setting.h"
#include "transports/codecs/can_channels.h"
#include "transports/codecs/can_channels_dbc.h"

namespace tribus {
namespace {

constexpr std::int64_t kMostBaseId = kMostExtendedId - can_channels::kFdIndex;

struct Options {
    std::int64_t id = can_channels::kDefaultBaseId;
    bool extended = false;
};

int print_dbc(const Options& options) {
    SettingValues settings;
    settings.set("id", options.id);
    settings.set("extended", options.extended);
    for (const SettingMistake& mistake : kCanProtocol.check(settings, SettingScope::output)) {
        fmt::print(stderr, "--{}: {}\n", mistake.path.front(), mistake.text);
        return kExitWrongUse;
    }
    fmt::print("{}", native_dbc(CanChannelsFormat::from_settings(settings)));
    return kExitFine;
}

}  // namespace

void add_dbc_command(CLI::App& app, int& status) {
    auto* command = app.add_subcommand(
        "dbc", "Print the native CAN format as a DBC file, for other tools on the bus");
    auto options = std::make_shared<Options>();
    command->add_option("--id", options->id, "Base id, as in the configuration")
        ->check(CLI::Range(std::int64_t{0}, kMostBaseId))
        ->default_str(fmt::format("0x{:X}", options->id));
    command->add_flag("--extended", options->extended, "Ids of 29 bits");
    command->callback([options, &status] { status = print_dbc(*options); });
}

}  // namespace tribus
