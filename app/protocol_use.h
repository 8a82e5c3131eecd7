#pragma once

#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <tl/expected.hpp>

#include "core/line_settings.h"
#include "core/setting.h"
#include "transports/codecs/protocol.h"

/// A protocol as the command line asks for it: settings of the protocol tables as options.
namespace tribus {

/// One protocol with its settings checked and its defaults filled in.
struct ProtocolUse {
    const Protocol* protocol = nullptr;
    SettingValues settings;
    LineSettings line;
};

/// Values as they stand on the command line, by key.
using GivenSettings = std::map<std::string, std::string, std::less<>>;

/// A value as it stands on the command line: as in the configuration, words without quotation
/// marks. The error says what is allowed.
tl::expected<SettingValue, std::string> setting_from_text(const Setting& setting,
                                                          std::string_view text);

/// `ibus, sbus`
std::string protocol_list();

/// The keys of all protocols in that direction that mean something to recorded bytes.
struct SettingOption {
    std::string key;
    std::string help;
};
std::vector<SettingOption> setting_options(SettingScope direction);

/// Every key in `given` must be one of the protocol's in that direction.
tl::expected<ProtocolUse, std::string> use_protocol(const Protocol& protocol,
                                                    SettingScope direction,
                                                    const GivenSettings& given);

/// The protocol of that name; for "auto" all that allow the values of those of `given` that they
/// have. The error says what is allowed.
tl::expected<std::vector<ProtocolUse>, std::string> choose_protocols(std::string_view name,
                                                                     SettingScope direction,
                                                                     const GivenSettings& given);

}  // namespace tribus
