#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "config/document.h"
#include "config/keys.h"
#include "config/mistakes.h"
#include "config/read_document.h"

namespace tribus {

/// What every reader needs at hand.
struct Reading {
    const LostText& lost;
    Mistakes& mistakes;
};

/// A table and where it stands, with a name for messages such as `[input.receiver]`.
struct TableRef {
    const Table& table;
    Location where;
    std::string title;
    /// Of an input or output: which of the two, and its protocol, where that is known.
    std::string_view side{};
    std::string_view protocol{};
};

/// A table held against its rows of the key table.
class TableContent {
  public:
    struct Item {
        const Key* key = nullptr;
        const Entry* entry = nullptr;
        bool sound = true;
        /// The entry names the place of another kind of link; its value is not judged.
        bool other_link = false;
    };

    TableContent(Location where, std::vector<Item> items, SettingValues values)
        : where_(where), items_(std::move(items)), values_(std::move(values)) {}

    /// Sound values that were given, and the defaults of all others.
    const SettingValues& values() const { return values_; }

    /// The entry of that key, also where its name was misspelt; null if there is none.
    const Entry* find(std::string_view key) const;
    bool given(std::string_view key) const { return find(key) != nullptr; }
    /// Not given, or given without a mistake.
    bool sound(std::string_view key) const;
    /// Of the value, or of the table where it is not given.
    Location where(std::string_view key) const;

  private:
    const Item* item(std::string_view key) const;

    Location where_;
    std::vector<Item> items_;
    SettingValues values_;
};

/// Adds a mistake for each unknown key, each missing one that is required, and each value that is
/// not allowed; keys of other kinds than `value` and `protocol` are found but not judged. Names in
/// `tolerated` are passed over. `keys` must outlive the result.
TableContent read_table(const TableRef& ref, std::span<const Key> keys, Reading reading,
                        std::span<const std::string_view> tolerated = {});

/// As above, of a table of the root that there is once, such as [runtime]. Nothing where it is not
/// there, or where its entry is no table, which is a mistake.
std::optional<TableContent> read_only_table(std::string_view name, const Entry* entry,
                                            std::span<const Key> keys, Reading reading);

/// The key that an entry of that name means: the same, or the nearest; null if there is none.
const Key* meant_key(std::string_view name, std::span<const Key> keys);

std::vector<std::string_view> names_of(std::span<const Key> keys);

/// Names of all protocols in the registry.
std::vector<std::string_view> protocol_names();
/// Of those that an input, or an output, can have.
std::vector<std::string_view> protocol_names(SettingScope way);

}  // namespace tribus
