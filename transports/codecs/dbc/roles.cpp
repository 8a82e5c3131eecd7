#include "transports/codecs/dbc/roles.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>
#include <vector>

#include "core/channel_frame.h"
#include "core/quotes.h"

namespace tribus {
namespace {

using Path = std::vector<std::string>;
using Mistakes = std::vector<SettingMistake>;

constexpr std::string_view kAllowedRoles =
    "allowed: a channel number, or one of { channel = 1 }, { flag = \"failsafe\" }, "
    "{ fixed = 0 }, { counter = true }, { checksum = \"xor\" }, { from = \"battery.voltage\" }";

struct NamedFlag {
    std::string_view name;
    DbcFlagMeaning meaning;
};
constexpr std::array kNamedFlags{
    NamedFlag{"failsafe", DbcFlagMeaning::failsafe},
    NamedFlag{"frame_lost", DbcFlagMeaning::frame_lost},
    NamedFlag{"good", DbcFlagMeaning::good},
    NamedFlag{"cause", DbcFlagMeaning::cause},
};

struct NamedChecksum {
    std::string_view name;
    DbcChecksumKind kind;
};
constexpr std::array kChecksums{
    NamedChecksum{"xor", DbcChecksumKind::xor8},
    NamedChecksum{"sum", DbcChecksumKind::sum8},
    NamedChecksum{"agilex", DbcChecksumKind::agilex},
    NamedChecksum{"crc8_j1850", DbcChecksumKind::crc8_1d},
    NamedChecksum{"crc8_2f", DbcChecksumKind::crc8_2f},
    NamedChecksum{"p01", DbcChecksumKind::p01},
    NamedChecksum{"p05", DbcChecksumKind::p05},
};

constexpr double kMostMicroseconds = 4000;

template <class Rows>
std::string names(const Rows& rows) {
    std::string text;
    for (const auto& row : rows) {
        text += (text.empty() ? "" : ", ") + in_quotes(row.name);
    }
    return text;
}

/// The table of one signal. Each key that is queried counts as known.
class RoleTable {
  public:
    RoleTable(const SettingTree::Table& table, Path path, Mistakes& mistakes)
        : table_(table), path_(std::move(path)), mistakes_(mistakes) {}

    bool has(std::string_view key) { return find(key) != nullptr; }
    std::optional<double> number(std::string_view key) {
        return read<double>(key, "a number",
                            [](const SettingTree& tree) { return number_of(tree); });
    }
    std::optional<std::int64_t> whole(std::string_view key, std::string_view allowed) {
        return read<std::int64_t>(key, allowed, [](const SettingTree& tree) {
            const auto* number = tree.as<std::int64_t>();
            return number == nullptr ? std::nullopt : std::optional(*number);
        });
    }
    std::optional<bool> truth(std::string_view key) {
        return read<bool>(key, "true or false", [](const SettingTree& tree) {
            const auto* value = tree.as<bool>();
            return value == nullptr ? std::nullopt : std::optional(*value);
        });
    }
    std::string text(std::string_view key, std::string_view allowed) {
        return read<std::string>(key, allowed,
                                 [](const SettingTree& tree) {
                                     const auto* value = tree.as<std::string>();
                                     return value == nullptr || value->empty()
                                                ? std::nullopt
                                                : std::optional(*value);
                                 })
            .value_or("");
    }
    /// Two different numbers.
    std::optional<std::array<double, 2>> pair(std::string_view key) {
        return read<std::array<double, 2>>(
            key, "two different numbers, such as [-100, 100]", [](const SettingTree& tree) {
                const auto* list = tree.as<SettingTree::List>();
                if (list == nullptr || list->size() != 2) {
                    return std::optional<std::array<double, 2>>();
                }
                const auto first = number_of((*list)[0]);
                const auto second = number_of((*list)[1]);
                return first && second && *first != *second
                           ? std::optional(std::array{*first, *second})
                           : std::nullopt;
            });
    }
    void refuse_others() {
        for (const SettingEntry& entry : table_) {
            if (std::ranges::find(known_, entry.key) == known_.end()) {
                const std::vector<std::string_view> known(known_.begin(), known_.end());
                complain(entry.key, "unknown key " + in_quotes(entry.key) +
                                        "; allowed here: " + in_quotes_all(known));
            }
        }
    }
    void complain(std::string_view key, std::string text) {
        Path path = path_;
        path.emplace_back(key);
        mistakes_.push_back({std::move(path), std::move(text)});
    }

  private:
    static std::optional<double> number_of(const SettingTree& tree) {
        if (const auto* whole = tree.as<std::int64_t>()) {
            return static_cast<double>(*whole);
        }
        const auto* fraction = tree.as<double>();
        return fraction == nullptr || !std::isfinite(*fraction) ? std::nullopt
                                                                : std::optional(*fraction);
    }
    const SettingTree* find(std::string_view key) {
        known_.emplace_back(key);
        const auto entry = std::ranges::find(table_, key, &SettingEntry::key);
        return entry == table_.end() ? nullptr : &entry->value;
    }
    template <class Result, class Reader>
    std::optional<Result> read(std::string_view key, std::string_view allowed, Reader reader) {
        const SettingTree* tree = find(key);
        if (tree == nullptr) {
            return std::nullopt;
        }
        std::optional<Result> result = reader(*tree);
        if (!result) {
            complain(key, in_quotes(key) + " has a wrong value; allowed: " + std::string(allowed));
        }
        return result;
    }

    const SettingTree::Table& table_;
    Path path_;
    Mistakes& mistakes_;
    std::vector<std::string> known_;
};

std::optional<std::size_t> channel_index(std::optional<std::int64_t> number) {
    const bool valid = number && *number >= 1 && *number <= std::int64_t{kChannelCount};
    return valid ? std::optional(static_cast<std::size_t>(*number - 1)) : std::nullopt;
}

std::optional<DbcRole> read_channel(RoleTable& table) {
    const auto number = table.whole("channel", "a channel number from 1 to 18");
    const auto channel = channel_index(number);
    if (number && !channel) {
        table.complain("channel",
                       "there is no channel " + std::to_string(*number) + "; allowed: 1 to 18");
    }
    DbcChannelRole role;
    role.value = table.pair("value");
    role.microseconds = table.pair("us").value_or(role.microseconds);
    if (std::ranges::any_of(role.microseconds,
                            [](double us) { return us < 0 || us > kMostMicroseconds; })) {
        table.complain("us", "this is not a servo pulse; allowed: 0 to 4000 microseconds");
    }
    role.not_available = table.whole("not_available", "a raw value, a whole number");
    role.error = table.whole("error", "a raw value, a whole number");
    if (role.error && role.error == role.not_available) {
        table.complain("error",
                       "\"not_available\" already has this code; allowed: another "
                       "raw value, or one of the two keys");
    }
    role.optional = table.truth("optional").value_or(false);
    constexpr std::string_view kSignalName = "the name of a signal of the same message";
    role.negative = table.text("negative", kSignalName);
    role.positive = table.text("positive", kSignalName);
    role.neutral = table.text("neutral", kSignalName);
    if (role.negative.empty() && !(role.positive.empty() && role.neutral.empty())) {
        table.complain("channel",
                       "\"positive\" and \"neutral\" give the direction of a magnitude together "
                       "with \"negative\"; allowed: all of them, or \"negative\" alone");
    }
    table.refuse_others();
    if (!channel) {
        return std::nullopt;
    }
    role.channel = *channel;
    return role;
}

std::optional<DbcRole> read_flag(RoleTable& table) {
    const std::string name = table.text("flag", names(kNamedFlags));
    table.refuse_others();
    const auto* row = std::ranges::find(kNamedFlags, name, &NamedFlag::name);
    if (row == kNamedFlags.end()) {
        if (!name.empty()) {
            table.complain(
                "flag", "there is no flag " + in_quotes(name) + "; allowed: " + names(kNamedFlags));
        }
        return std::nullopt;
    }
    return DbcFlagRole{row->meaning};
}

std::optional<DbcRole> read_fixed(RoleTable& table) {
    const auto value = table.number("fixed");
    table.refuse_others();
    return value ? std::optional<DbcRole>(DbcFixedRole{*value}) : std::nullopt;
}

std::optional<DbcRole> read_counter(RoleTable& table) {
    const auto wanted = table.truth("counter");
    DbcCounterRole role{table.whole("most", "the highest count, a whole number above 0")};
    table.refuse_others();
    if (role.most && *role.most < 1) {
        table.complain("most", "a counter that never changes is useless; allowed: 1 or more");
        return std::nullopt;
    }
    if (wanted == false) {
        table.complain("counter",
                       "this gives the signal no role; allowed: true, or no entry for the signal");
    }
    return wanted == true ? std::optional<DbcRole>(role) : std::nullopt;
}

std::optional<DbcRole> read_checksum(RoleTable& table) {
    const std::string name = table.text("checksum", names(kChecksums));
    DbcChecksumRole role{.kind = {}, .data_id = table.whole("data_id", "0 to 65535")};
    table.refuse_others();
    const auto* row = std::ranges::find(kChecksums, name, &NamedChecksum::name);
    if (row == kChecksums.end()) {
        if (!name.empty()) {
            table.complain("checksum", "there is no checksum " + in_quotes(name) +
                                           "; allowed: " + names(kChecksums));
        }
        return std::nullopt;
    }
    if (role.data_id && (*role.data_id < 0 || *role.data_id > 0xFFFF)) {
        table.complain("data_id", "a data id has 16 bits; allowed: 0 to 65535");
        return std::nullopt;
    }
    if (role.data_id && !is_profile(row->kind)) {
        table.complain("data_id", in_quotes(name) +
                                      " has no data id; allowed: with \"p01\" and "
                                      "\"p05\" only");
        return std::nullopt;
    }
    role.kind = row->kind;
    return role;
}

std::optional<DbcRole> read_value(RoleTable& table) {
    DbcValueRole role{.from = table.text("from", "the name of a value, such as \"cells\""),
                      .not_available = table.whole("not_available", "a raw value, a whole number")};
    table.refuse_others();
    return role.from.empty() ? std::nullopt : std::optional<DbcRole>(std::move(role));
}

}  // namespace

bool is_profile(DbcChecksumKind kind) {
    return kind == DbcChecksumKind::p01 || kind == DbcChecksumKind::p05;
}

std::optional<DbcRole> read_dbc_role(const SettingTree& tree, const std::vector<std::string>& path,
                                     std::vector<SettingMistake>& mistakes) {
    if (const auto* number = tree.as<std::int64_t>()) {
        const auto channel = channel_index(*number);
        if (!channel) {
            mistakes.push_back(
                {path, "there is no channel " + std::to_string(*number) + "; allowed: 1 to 18"});
            return std::nullopt;
        }
        return DbcChannelRole{.channel = *channel};
    }
    struct Kind {
        std::string_view key;
        std::optional<DbcRole> (*read)(RoleTable&);
    };
    static constexpr std::array kKinds{
        Kind{"channel", read_channel}, Kind{"flag", read_flag},         Kind{"fixed", read_fixed},
        Kind{"counter", read_counter}, Kind{"checksum", read_checksum}, Kind{"from", read_value},
    };
    if (const auto* entries = tree.as<SettingTree::Table>()) {
        for (const Kind& kind : kKinds) {
            if (std::ranges::find(*entries, kind.key, &SettingEntry::key) != entries->end()) {
                RoleTable table(*entries, path, mistakes);
                return kind.read(table);
            }
        }
    }
    mistakes.push_back({path, "this gives the signal no role; " + std::string(kAllowedRoles)});
    return std::nullopt;
}

}  // namespace tribus
