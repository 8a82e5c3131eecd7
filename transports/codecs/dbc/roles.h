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

/// What the user says of one signal: `MESSAGE.SIGNAL = 3` or `= { channel = 3, ... }`, read from
/// the tree, not yet held against the DBC file. Pure and reentrant.
namespace tribus {

struct DbcChannelRole {
    std::size_t channel = 0;  ///< from 0
    std::optional<std::array<double, 2>> value{};
    std::array<double, 2> microseconds{1000, 2000};
    std::optional<std::int64_t> not_available{};
    std::optional<std::int64_t> error{};
    bool optional = false;
    std::string negative{};  ///< names of signals of the same message; empty: none
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
/// Of an output: a named value is sent.
struct DbcValueRole {
    std::string from{};
    std::optional<std::int64_t> not_available{};
};
using DbcRole = std::variant<DbcChannelRole, DbcFlagRole, DbcFixedRole, DbcCounterRole,
                             DbcChecksumRole, DbcValueRole>;

/// The end-to-end profiles of AUTOSAR, which cover a data id that is not sent.
bool is_profile(DbcChecksumKind kind);

/// Reads what stands behind one signal. Adds what is wrong to `mistakes`, under `path`.
std::optional<DbcRole> read_dbc_role(const SettingTree& tree, const std::vector<std::string>& path,
                                     std::vector<SettingMistake>& mistakes);

}  // namespace tribus
