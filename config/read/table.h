#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "config/keys/keys.h"
#include "config/language/document.h"
#include "config/language/mistakes.h"
#include "config/language/read_document.h"

namespace tribus {

/// Common arguments of all readers.
struct Reading {
    const LostText& lost;
    Mistakes& mistakes;
    /// What is allowed, but probably not meant.
    Mistakes& warnings;
};

/// A table and its place in the file. `title` names it in messages, such as `[input.receiver]`.
struct TableRef {
    const Table& table;
    Location where;
    std::string title;
    /// For an input or output: "input" or "output", and the name of its protocol if known.
    std::string_view side{};
    std::string_view protocol{};
};

/// The entries of a table, assigned to rows of the key table.
class TableContent {
  public:
    struct Item {
        const Key* key = nullptr;
        const Entry* entry = nullptr;
        bool sound = true;
        /// The entry is the place key of another medium. Its value is not checked.
        bool other_place = false;
    };

    TableContent(Location where, std::span<const Key> keys, std::vector<Item> items,
                 SettingValues values)
        : where_(where), keys_(keys), items_(std::move(items)), values_(std::move(values)) {}

    /// The valid values that were given, and the defaults of all keys that were not.
    const SettingValues& values() const { return values_; }

    /// Sets the members of `object` that the rows name: given values, and defaults of rows. Members
    /// without a value stay as they are.
    template <class Owner>
    void read_into(Owner& object) const {
        set_members(&object, &kOwner<Owner>, false);
    }
    /// The same without defaults: only what was given.
    template <class Owner>
    void read_given_into(Owner& object) const {
        set_members(&object, &kOwner<Owner>, true);
    }

    /// The entry of that key, also if its name was misspelt. Null if there is none.
    const Entry* find(std::string_view key) const;
    bool given(std::string_view key) const { return find(key) != nullptr; }
    /// True if the key was not given, or was given without a mistake.
    bool sound(std::string_view key) const;
    /// Place of the value, or of the table if it was not given.
    Location where(std::string_view key) const;

  private:
    const Item* item(std::string_view key) const;
    void set_members(void* object, const char* owner, bool only_given) const;

    Location where_;
    std::span<const Key> keys_;
    std::vector<Item> items_;
    SettingValues values_;
};

/// Checks a table against `keys`. Adds a mistake for each unknown key, each missing required key,
/// and each value that is not allowed. Does not check values of kinds other than `value` and
/// `protocol`. Ignores the names in `tolerated`. `keys` must outlive the result.
TableContent read_table(const TableRef& ref, std::span<const Key> keys, Reading reading,
                        std::span<const std::string_view> tolerated = {});

/// The same for a table that may exist once at the top, such as [runtime]. `nullopt` if it does not
/// exist, or if it is not a table, which is a mistake.
std::optional<TableContent> read_only_table(std::string_view name, const Entry* entry,
                                            std::span<const Key> keys, Reading reading);

/// The key with that name, or with the nearest name. Null if there is none.
const Key* meant_key(std::string_view name, std::span<const Key> keys);

std::vector<std::string_view> names_of(std::span<const Key> keys);

}  // namespace tribus
