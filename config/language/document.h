#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "config/schema/schema.h"

/// A TOML document as plain values with their places in the file. Only parse_toml.cpp sees the TOML
/// library.
namespace tribus {

struct DateOrTime {};

struct Value;
struct Entry;

struct List {
    std::vector<Value> items;
    /// Its items are tables under headers of the form `[[name]]`.
    bool of_headers = false;
};

/// A table, with its entries in the order of the file.
struct Table {
    std::vector<Entry> entries;

    /// The entry with that key. Null if there is none.
    const Entry* find(std::string_view key) const;
};

/// A value and its place in the file.
struct Value {
    Location where;
    std::variant<bool, std::int64_t, double, std::string, DateOrTime, List, Table> content;

    template <class T>
    const T* as() const {
        return std::get_if<T>(&content);
    }
};

/// A key with its value.
struct Entry {
    std::string key;
    Location where;  ///< place of the key
    Value value;
};

inline const Entry* Table::find(std::string_view key) const {
    for (const Entry& entry : entries) {
        if (entry.key == key) {
            return &entry;
        }
    }
    return nullptr;
}

/// The value in words for a message: `20`, `"abc"`, `true`, `[1, 2]`, `a list`, `a table`.
std::string describe(const Value& value);

}  // namespace tribus
