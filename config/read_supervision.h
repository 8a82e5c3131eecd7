#pragma once

#include "config/read_table.h"

namespace tribus {

/// How an input is judged, from the content of [input.NAME]. `settings_sound`: what the protocol's
/// own settings say of its wire format is certain.
SupervisionSettings read_supervision(const TableContent& content, const Protocol* protocol,
                                     const SettingValues& settings, bool settings_sound,
                                     Reading reading);

/// Whether the decoder of an input can mark a frame as frame-lost or failsafe. On CAN each can: it
/// also judges values that are missing and messages that do not come.
bool has_flags(const Protocol& protocol, const SettingValues& settings);

}  // namespace tribus
