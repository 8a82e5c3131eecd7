#pragma once

#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <tl/expected.hpp>

#include "app/command.h"
#include "core/line_settings.h"
#include "core/setting.h"
#include "core/time.h"
#include "pipelines/settings.h"
#include "transports/codecs/protocol.h"

/// A protocol as the command line asks for it: settings of the protocol tables as options.
namespace tribus {

/// One protocol with its settings checked and its defaults filled in.
struct ProtocolUse {
    const Protocol* protocol = nullptr;
    SettingValues settings;
    LineSettings line;
    /// The detectors of the input of a configuration; none of other uses.
    std::optional<SupervisionSettings> supervision{};
};

/// Those on one kind of link.
std::vector<ProtocolUse> of_link(std::span<const ProtocolUse> uses, LinkKind link);

/// Time from one frame to the next where nothing else says it: the protocol's own, which its
/// settings may tell.
Duration usual_period(const ProtocolUse& use);

/// Values as they stand on the command line, by key.
using GivenSettings = std::map<std::string, std::string, std::less<>>;

/// A value as it stands on the command line: as in the configuration, words without quotation
/// marks. The error says what is allowed.
tl::expected<SettingValue, std::string> setting_from_text(const Setting& setting,
                                                          std::string_view text);

/// `ibus, sbus`
std::string protocol_list();
/// Those of one kind of link.
std::string protocol_list(LinkKind link);

/// The keys of all protocols in that direction that mean something to recorded bytes.
struct SettingOption {
    std::string key;
    std::string help;
    /// Words that are allowed, `a,b`; empty where a protocol wants something else.
    std::string choices;
};
std::vector<SettingOption> setting_options(SettingScope direction);

/// Adds them as options of a command; their values go to `given`, which lives as long as these.
void append_setting_options(std::vector<CommandOption>& options, SettingScope direction,
                            GivenSettings& given);

/// Every key in `given` must be one of the protocol's in that direction, those that it requires
/// must be there, and together they must make sense to it.
tl::expected<ProtocolUse, std::string> use_protocol(const Protocol& protocol,
                                                    SettingScope direction,
                                                    const GivenSettings& given);

/// The protocol of that name; for "auto" all that allow the values of those of `given` that they
/// have, and require no others: at least one for each of `given`. The error says what is allowed.
tl::expected<std::vector<ProtocolUse>, std::string> choose_protocols(std::string_view name,
                                                                     SettingScope direction,
                                                                     const GivenSettings& given);

}  // namespace tribus
