#pragma once

#include <string>
#include <vector>

#include "core/can_frame.h"
#include "core/setting.h"
#include "transports/codecs/dbc/file.h"
#include "transports/codecs/dbc/map.h"

/// One message of a DbcMap. Pure and reentrant.
namespace tribus {

/// The ids of the frames of a message: in J1939 of any priority, and from any source where the
/// file has 0xFE, from which nobody may send.
CanIdMatch received_ids(const DbcMessage& message);

/// Adds the message and its parts to the map of an input or output, as `roles` tell what its
/// signals are for. Adds what is wrong to `mistakes`, under `path`.
void map_dbc_message(const DbcMessage& message, const SettingTree::Table& roles,
                     const std::vector<std::string>& path, SettingScope scope, DbcMap& map,
                     std::vector<SettingMistake>& mistakes);

}  // namespace tribus
