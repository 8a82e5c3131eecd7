#pragma once

#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <tl/expected.hpp>

#include "app/cli/command.h"
#include "core/line_settings.h"
#include "core/setting.h"
#include "core/time.h"
#include "pipelines/rules/settings.h"
#include "transports/codecs/protocol.h"
#include "transports/links/medium.h"

/// Protocols on the command line: the settings of the protocol tables become options.
namespace tribus {

/// A protocol with checked settings and defaults filled in.
struct ProtocolUse {
    const Protocol* protocol = nullptr;
    SettingValues settings;
    LineSettings line;
    /// Loss detection of the configured input; empty without a configuration.
    std::optional<SupervisionSettings> supervision{};
};

/// The uses whose protocol has that shape.
std::vector<ProtocolUse> of_shape(std::span<const ProtocolUse> uses, WireShape shape);

/// Usual time from one frame to the next: the protocol's default, which its settings may change.
Duration usual_period(const ProtocolUse& use);

/// Values from the command line, by key.
using GivenSettings = std::map<std::string, std::string, std::less<>>;

/// Parses a value from the command line: as in the configuration, but without quotation marks. The
/// error says what is allowed.
tl::expected<SettingValue, std::string> setting_from_text(const Setting& setting,
                                                          std::string_view text);

/// Why recorded frames cannot be read or made with these settings. Empty: they can.
std::string refusal_of_key(const Protocol& protocol, const SettingValues& settings);

/// Names of all protocols that can be decoded (input) or encoded: `ibus, sbus`.
std::string protocol_list(SettingScope direction);
/// Names of the protocols that the medium carries.
std::string protocol_list(const Medium& medium);

/// The same as a list.
std::vector<std::string> protocol_names_for(SettingScope direction);
std::vector<std::string> protocol_names_on(const Medium& medium);

/// The settings of recorded bytes as options of a command, each key once: those of the protocol, or
/// of all protocols if none has that name. Their values go to `given`, which must outlive them.
std::vector<CommandOption> setting_options(SettingScope direction, std::string_view protocol,
                                           GivenSettings& given);

/// Notes of a command with these options: its name, and the names of the protocols.
inline constexpr const char* kProtocolNotes =
    "The protocols: {1}.\nThe settings of each are further options; those of sbus, for one:\n"
    "`tribus {0} --protocol sbus --help`";

/// The same for a command with an option `--protocol`.
SelectedOptions settings_by_protocol(SettingScope direction, GivenSettings& given);

/// Checks the settings: `given` may hold only keys of the protocol in that direction, required keys
/// must be there, and the values must fit together. The error says what is allowed.
tl::expected<ProtocolUse, std::string> use_protocol(const Protocol& protocol,
                                                    SettingScope direction,
                                                    const GivenSettings& given);

/// The protocol `name`, or for "auto" all protocols that accept those of the `given` settings that
/// they have and require no others. Each given setting must be used. The error says what is
/// allowed.
tl::expected<std::vector<ProtocolUse>, std::string> choose_protocols(std::string_view name,
                                                                     SettingScope direction,
                                                                     const GivenSettings& given);

}  // namespace tribus
