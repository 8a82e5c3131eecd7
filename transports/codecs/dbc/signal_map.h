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

/// Combines the role of one signal with the signal of the file. Pure and reentrant.
namespace tribus {

/// Names of messages or signals for an error message. Long lists are cut.
template <class Rows>
std::string dbc_names(const Rows& rows) {
    constexpr std::size_t kMostNames = 12;
    std::string text;
    for (std::size_t i = 0; i < rows.size() && i < kMostNames; ++i) {
        text += (i == 0 ? "" : ", ") + in_quotes(rows[i].name);
    }
    return rows.size() > kMostNames ? text + ", ..." : text;
}

/// Error message for a message or signal (`kind`) that the file describes wrongly.
std::string unusable_in_dbc(std::string_view kind, const DbcUnusable& part);
/// Error message for a message name that the file does not have, or describes wrongly.
std::string no_dbc_message(const DbcFile& file, std::string_view name);

/// A selector, with the values for which a signal is present.
struct DbcCondition {
    const DbcSignal* selector = nullptr;
    std::vector<DbcSelectorRange> selected_by;

    bool operator==(const DbcCondition&) const = default;
};
/// All selectors on which a signal depends, the outermost first.
using DbcConditions = std::vector<DbcCondition>;

using DbcUse = std::variant<DbcChannel, DbcFlag, DbcFixed, DbcCounter, DbcChecksum, DbcValue>;

struct DbcMappedSignal {
    const DbcSignal* signal = nullptr;
    std::vector<std::string> path;  ///< path of its entry
    DbcConditions conditions;
    DbcUse use;
};

/// Adds errors to `mistakes`, under `path`, the path of `entry`. The result points into `message`.
std::optional<DbcMappedSignal> map_dbc_signal(const DbcMessage& message, const SettingEntry& entry,
                                              const std::vector<std::string>& path,
                                              std::vector<SettingMistake>& mistakes);

}  // namespace tribus
