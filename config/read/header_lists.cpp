#include "config/read/header_lists.h"

#include <fmt/format.h>

#include <span>
#include <string>
#include <utility>

#include "config/keys/keys.h"
#include "config/read/table.h"

namespace tribus {
namespace {

void replace_lists_in(Table& table, std::span<const Key> keys, const std::string& path,
                      Mistakes& mistakes);

/// Makes a table of a list of tables that should be one.
void replace_list(Value& value, const std::string& path, Mistakes& mistakes) {
    auto* list = std::get_if<List>(&value.content);
    if (list == nullptr || !list->of_headers) {
        return;
    }
    for (const Value& item : list->items) {
        mistakes.add(item.where,
                     &item == &list->items.front()
                         ? fmt::format("[[{0}]] makes a list of tables; write [{0}]", path)
                         : "this table was already given further up; give each once");
    }
    Value first = std::move(list->items.front());
    value = std::move(first);
}

void replace_lists_under(Value& value, const Key& key, const std::string& path,
                         Mistakes& mistakes) {
    auto* tables = std::get_if<Table>(&value.content);
    if (tables == nullptr) {
        return;
    }
    if (key.kind == KeyKind::named_tables) {
        for (Entry& entry : tables->entries) {
            const std::string named = fmt::format("{}.{}", path, entry.key);
            replace_list(entry.value, named, mistakes);
            if (auto* table = std::get_if<Table>(&entry.value.content)) {
                replace_lists_in(*table, key.inside, named, mistakes);
            }
        }
    } else {
        replace_lists_in(*tables, key.inside, path, mistakes);
    }
}

void replace_lists_in(Table& table, std::span<const Key> keys, const std::string& path,
                      Mistakes& mistakes) {
    for (Entry& entry : table.entries) {
        const Key* key = meant_key(entry.key, keys);
        const std::string inside = path.empty() ? entry.key : fmt::format("{}.{}", path, entry.key);
        // for_each_named explains a list in the place of named tables.
        const bool may_be_list =
            key != nullptr && (key->kind == KeyKind::list || key->kind == KeyKind::named_tables);
        if (!may_be_list) {
            replace_list(entry.value, inside, mistakes);
        }
        if (key != nullptr) {
            replace_lists_under(entry.value, *key, inside, mistakes);
        } else if (auto* own = std::get_if<Table>(&entry.value.content)) {
            // A key of a protocol. None has lists of tables.
            replace_lists_in(*own, {}, inside, mistakes);
        }
    }
}

}  // namespace

void replace_header_lists(Table& root, Mistakes& mistakes) {
    replace_lists_in(root, root_keys(), {}, mistakes);
}

}  // namespace tribus
