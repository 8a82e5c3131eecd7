#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/quotes.h"
#include "core/setting.h"
#include "transports/codecs/dbc/file.h"
#include "transports/codecs/dbc/map.h"

/// One signal of a DbcMap: what the user says of it, held against what the file says. Pure and
/// reentrant.
namespace tribus {

/// The names of messages or signals for a message to a person; long lists help nobody.
template <class Rows>
std::string dbc_names(const Rows& rows) {
    constexpr std::size_t kMostNames = 12;
    std::string text;
    for (std::size_t i = 0; i < rows.size() && i < kMostNames; ++i) {
        text += (i == 0 ? "" : ", ") + in_quotes(rows[i].name);
    }
    return rows.size() > kMostNames ? text + ", ..." : text;
}

/// What a person reads who names a message that the file does not have.
std::string no_dbc_message(const DbcFile& file, std::string_view name);

/// A selector and those of its values with which a signal is present.
struct DbcCondition {
    const DbcSignal* selector = nullptr;
    std::vector<DbcSelectorRange> selected_by;

    bool operator==(const DbcCondition&) const = default;
};
/// All that a signal depends on, the outermost selector first.
using DbcConditions = std::vector<DbcCondition>;

using DbcUse = std::variant<DbcChannel, DbcFlag, DbcFixed, DbcCounter, DbcChecksum, DbcValue>;

struct DbcMappedSignal {
    const DbcSignal* signal = nullptr;
    std::vector<std::string> path;  ///< of its entry
    DbcConditions conditions;
    DbcUse use;
};

/// Adds what is wrong to `mistakes`, under `path`, which leads to `entry`. The result points into
/// `message`.
std::optional<DbcMappedSignal> map_dbc_signal(const DbcMessage& message, const SettingEntry& entry,
                                              const std::vector<std::string>& path,
                                              std::vector<SettingMistake>& mistakes);

}  // namespace tribus
