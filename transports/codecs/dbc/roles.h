#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/setting.h"
#include "transports/codecs/dbc/map.h"

/// The role that the user gives a signal: `MESSAGE.SIGNAL = 3` or `= { channel = 3, ... }`. Read
/// from the tree, not yet compared with the DBC file. Pure and reentrant.
namespace tribus {

struct DbcChannelRole {
    std::size_t channel = 0;  ///< from 0
    std::optional<std::array<double, 2>> value{};
    std::array<double, 2> microseconds{1000, 2000};
    std::optional<std::int64_t> not_available{};
    std::optional<std::int64_t> error{};
    bool optional = false;
    std::string negative{};  ///< name of a signal of the same message, as the next two; empty: none
    std::string positive{};
    std::string neutral{};
};
struct DbcFlagRole {
    DbcFlagMeaning meaning = DbcFlagMeaning::failsafe;
};
struct DbcFixedRole {
    double value = 0;
};
struct DbcCounterRole {
    std::optional<std::int64_t> most;
};
struct DbcChecksumRole {
    DbcChecksumKind kind = DbcChecksumKind::xor8;
    std::optional<std::int64_t> data_id;
};
/// Output only: sends a named value.
struct DbcValueRole {
    std::string from{};
    std::optional<std::int64_t> not_available{};
};
using DbcRole = std::variant<DbcChannelRole, DbcFlagRole, DbcFixedRole, DbcCounterRole,
                             DbcChecksumRole, DbcValueRole>;

/// Whether this is an end-to-end profile of AUTOSAR, whose CRC covers a data id that is not sent.
bool is_profile(DbcChecksumKind kind);

/// Reads the value of one signal's key. Adds errors to `mistakes`, under `path`.
std::optional<DbcRole> read_dbc_role(const SettingTree& tree, const std::vector<std::string>& path,
                                     std::vector<SettingMistake>& mistakes);

}  // namespace tribus
