#include "config/read_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "config/key_homes.h"
#include "config/nearest.h"
#include "config/read_value.h"
#include "config/values.h"
#include "core/quotes.h"
#include "transports/registry/registry.h"

namespace tribus {
namespace {

const Key* exact_key(std::string_view name, std::span<const Key> keys) {
    const auto key = std::find_if(keys.begin(), keys.end(),
                                  [name](const Key& row) { return row.name() == name; });
    return key == keys.end() ? nullptr : &*key;
}

void report_unknown(const TableRef& ref, const Entry& entry, std::span<const Key> keys,
                    Mistakes& mistakes) {
    const auto names = names_of(keys);
    const std::string home = nearest(entry.key, names) ? "" : home_of_key(entry.key, ref.protocol);
    mistakes.add(entry.where, fmt::format("unknown {} {} in {}; {}{}",
                                          entry.value.as<Table>() == nullptr ? "key" : "table",
                                          in_quotes(entry.key), ref.title,
                                          home.empty() ? "" : "it belongs in " + home + "; ",
                                          suggestion(entry.key, names)));
}

/// Which entry is which key. An entry with a misspelt name stands for the key that was meant, so
/// that its value is judged in the same run and the key does not count as missing.
std::vector<TableContent::Item> match(const TableRef& ref, std::span<const Key> keys,
                                      std::span<const std::string_view> tolerated,
                                      Mistakes& mistakes) {
    std::vector<TableContent::Item> items;
    for (const Entry& entry : ref.table.entries) {
        if (const Key* key = exact_key(entry.key, keys)) {
            items.push_back({key, &entry});
        }
    }
    for (const Entry& entry : ref.table.entries) {
        const bool is_tolerated =
            std::find(tolerated.begin(), tolerated.end(), entry.key) != tolerated.end();
        if (is_tolerated || exact_key(entry.key, keys) != nullptr) {
            continue;
        }
        report_unknown(ref, entry, keys, mistakes);
        const Key* meant = meant_key(entry.key, keys);
        const bool taken = std::any_of(items.begin(), items.end(),
                                       [meant](const auto& item) { return item.key == meant; });
        if (meant != nullptr && !taken) {
            items.push_back({meant, &entry});
        }
    }
    return items;
}

std::optional<SettingValue> read_protocol_name(const Value& value, Mistakes& mistakes) {
    const auto names = protocol_names();
    const Setting setting{.key = "protocol", .type = SettingType::choice, .choices = names};
    return read_value(setting, value, mistakes);
}

bool has_value(const Key& key) {
    return key.kind == KeyKind::value || key.kind == KeyKind::protocol;
}

void report_missing(const TableRef& ref, const Key& key, Reading reading) {
    if (reading.lost.hurts(ref.where)) {
        return;
    }
    const std::string meaning = key.kind == KeyKind::protocol
                                    ? "one of " + in_quotes_all(protocol_names())
                                    : std::string(key.setting.help);
    reading.mistakes.add(ref.where, fmt::format("{} lacks {}; required: {}", ref.title,
                                                in_quotes(key.name()), meaning));
}

}  // namespace

const TableContent::Item* TableContent::item(std::string_view key) const {
    const auto item = std::find_if(items_.begin(), items_.end(), [key](const Item& candidate) {
        return candidate.key->name() == key;
    });
    return item == items_.end() ? nullptr : &*item;
}

const Entry* TableContent::find(std::string_view key) const {
    const Item* found = item(key);
    return found == nullptr ? nullptr : found->entry;
}

bool TableContent::sound(std::string_view key) const {
    const Item* found = item(key);
    return found == nullptr || found->sound;
}

Location TableContent::where(std::string_view key) const {
    const Item* found = item(key);
    return found == nullptr ? where_ : found->entry->value.where;
}

TableContent read_table(const TableRef& ref, std::span<const Key> keys, Reading reading,
                        std::span<const std::string_view> tolerated) {
    auto items = match(ref, keys, tolerated, reading.mistakes);
    SettingValues values;
    for (const Key& key : keys) {
        const auto item = std::find_if(items.begin(), items.end(), [&key](const auto& candidate) {
            return candidate.key == &key;
        });
        if (item == items.end()) {
            if (key.setting.required) {
                report_missing(ref, key, reading);
            } else if (!key.setting.fallback.empty()) {
                values.set(key.name(), default_of(key.setting));
            }
        } else if (has_value(key)) {
            auto value = key.kind == KeyKind::protocol
                             ? read_protocol_name(item->entry->value, reading.mistakes)
                             : read_value(key.setting, item->entry->value, reading.mistakes);
            item->sound = value.has_value();
            if (value) {
                values.set(key.name(), std::move(*value));
            } else if (!key.setting.fallback.empty()) {
                values.set(key.name(), default_of(key.setting));
            }
        }
    }
    return {ref.where, std::move(items), std::move(values)};
}

const Key* meant_key(std::string_view name, std::span<const Key> keys) {
    const auto names = names_of(keys);
    if (const Key* key = exact_key(name, keys)) {
        return key;
    }
    const auto near = nearest(name, names);
    return near ? exact_key(*near, keys) : nullptr;
}

std::vector<std::string_view> names_of(std::span<const Key> keys) {
    std::vector<std::string_view> names;
    for (const Key& key : keys) {
        names.push_back(key.name());
    }
    return names;
}

std::vector<std::string_view> protocol_names() {
    std::vector<std::string_view> names;
    for (const Protocol* protocol : protocols()) {
        names.push_back(protocol->name);
    }
    return names;
}

}  // namespace tribus
