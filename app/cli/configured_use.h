#pragma once

#include <string>

#include <tl/expected.hpp>

#include "app/cli/protocol_use.h"
#include "core/setting.h"

namespace tribus {

/// Protocol and settings of an input or output of a configuration, `FILE:NAME`. An input can be
/// used to encode and an output to decode, if its settings are valid in that direction. The error
/// says what is wrong and what is allowed; mistakes in the file are printed before.
tl::expected<ProtocolUse, std::string> configured_use(const std::string& file_and_name,
                                                      SettingScope direction);

/// Help text of `--as`.
inline constexpr const char* kAsHelp =
    "Protocol and settings of that input or output of a configuration, instead of --protocol and "
    "the settings";

/// Message for options that exclude `--as`.
inline constexpr const char* kAsAlone =
    "--as names the protocol and its settings; leave out the others";

}  // namespace tribus
