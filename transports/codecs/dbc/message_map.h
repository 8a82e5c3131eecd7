#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/can_frame.h"
#include "core/setting.h"
#include "transports/codecs/dbc/file.h"
#include "transports/codecs/dbc/map.h"

/// Builds one message of a DbcMap. Pure and reentrant.
namespace tribus {

/// The ids of a message's frames. In J1939: any priority, and any source if the file has the
/// address 0xFE, from which no node may send.
CanIdMatch received_ids(const DbcMessage& message);
/// Whether the file leaves the source address of its J1939 id open: 0xFE.
bool leaves_source_open(const DbcMessage& message);

/// The end of the bus for which a map is built.
struct DbcEnd {
    SettingScope scope = SettingScope::input;
    /// J1939: fills the source address of sent ids that the file leaves open.
    std::optional<std::uint8_t> own_address{};
};

/// Adds the message and its parts to the map of an input or output. `roles` are the roles of its
/// signals. Adds errors to `mistakes`, under `path`.
void map_dbc_message(const DbcMessage& message, const SettingTree::Table& roles,
                     const std::vector<std::string>& path, const DbcEnd& end, DbcMap& map,
                     std::vector<SettingMistake>& mistakes);

}  // namespace tribus
