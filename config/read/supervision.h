#pragma once

#include "config/read/table.h"

namespace tribus {

/// Reads from [input.NAME] how the link of an input is judged. `settings_sound`: the protocol's
/// settings are valid, so its wire format is known.
SupervisionSettings read_supervision(const TableContent& content, const Protocol* protocol,
                                     const SettingValues& settings, bool settings_sound,
                                     Reading reading);

/// Whether the key is for inputs whose decoder can mark frames (`has_flags`).
bool is_about_flags(std::string_view key);

/// Whether the decoder of an input can mark a frame as frame-lost or failsafe. Every decoder on CAN
/// can, because it also judges missing values and missing messages.
bool has_flags(const Protocol& protocol, const SettingValues& settings);

}  // namespace tribus
