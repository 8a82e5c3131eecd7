#include "config/read/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "config/keys/homes.h"
#include "config/keys/words.h"
#include "config/language/nearest.h"
#include "config/language/protocol_words.h"
#include "config/read/key_hints.h"
#include "config/read/value.h"
#include "core/quotes.h"
#include "transports/registry/registry.h"

namespace tribus {
namespace {

const Key* exact_key(std::string_view name, std::span<const Key> keys) {
    const auto key = std::find_if(keys.begin(), keys.end(),
                                  [name](const Key& row) { return row.name() == name; });
    return key == keys.end() ? nullptr : &*key;
}

bool is_place(std::string_view name) {
    return std::ranges::any_of(media(),
                               [name](const Medium* medium) { return medium->place.key == name; });
}

SettingScope way_of(const TableRef& ref) {
    return ref.side == "output" ? SettingScope::output : SettingScope::input;
}

/// If `name` is the place key of another medium, such as "device" on CAN: the right place key.
const Key* place_instead(std::string_view name, const TableRef& ref, std::span<const Key> keys) {
    if (find_protocol(ref.protocol) == nullptr || !is_place(name)) {
        return nullptr;
    }
    const auto own =
        std::ranges::find_if(keys, [](const Key& key) { return is_place(key.name()); });
    return own == keys.end() ? nullptr : &*own;
}

/// Lists the media that carry the protocol: `"device"`, `between`, the meaning of the key; then the
/// others.
std::string places_of(const Protocol& protocol, std::string_view between) {
    std::string places;
    for (const Medium* medium : media_for(protocol)) {
        places +=
            fmt::format("{}{}{}{}", places.empty() ? "" : "; or ", in_quotes(medium->place.key),
                        places.empty() ? between : ": ", medium->place.help);
    }
    return places;
}

void report_other_place(const TableRef& ref, const Entry& entry, const Key& place, bool taken,
                        Mistakes& mistakes) {
    const Protocol& protocol = *find_protocol(ref.protocol);
    const bool would_do = std::ranges::any_of(media_for(protocol), [&entry](const Medium* medium) {
        return medium->place.key == entry.key;
    });
    if (taken && would_do) {
        mistakes.add(entry.where,
                     fmt::format("{} in {}, which has {} already; leave one of them out",
                                 in_quotes(entry.key), ref.title, in_quotes(place.name())));
        return;
    }
    mistakes.add(entry.where, fmt::format("unknown key {} in {}; protocol {} has {}",
                                          in_quotes(entry.key), ref.title, in_quotes(ref.protocol),
                                          places_of(protocol, " instead: ")));
}

void report_unknown(const TableRef& ref, const Entry& entry, std::span<const Key> keys,
                    Mistakes& mistakes) {
    if (mistakes.full()) {
        mistakes.count();
        return;
    }
    const auto names = names_of(keys);
    const std::string unknown =
        fmt::format("unknown {} {} in {}; ", entry.value.as<Table>() == nullptr ? "key" : "table",
                    in_quotes(entry.key), ref.title);
    if (const auto hint = hint_for_key(entry, ref, keys)) {
        mistakes.add(entry.where, unknown + *hint);
        return;
    }
    const std::string home =
        nearest(entry.key, names) ? "" : home_of_key(entry.key, ref.side, ref.protocol);
    mistakes.add(entry.where, unknown + (home.empty() ? "" : "it belongs in " + home + "; ") +
                                  suggestion(entry.key, names));
}

/// Assigns entries to keys. An entry with a misspelt name counts as the key that was meant, so that
/// its value is checked too and the key is not reported as missing.
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
        const Key* place = place_instead(entry.key, ref, keys);
        const Key* meant = place != nullptr  ? place
                           : mistakes.full() ? nullptr
                                             : meant_key(entry.key, keys);
        const bool taken = std::any_of(items.begin(), items.end(),
                                       [meant](const auto& item) { return item.key == meant; });
        if (place != nullptr) {
            report_other_place(ref, entry, *place, taken, mistakes);
        } else {
            report_unknown(ref, entry, keys, mistakes);
        }
        if (meant != nullptr && !taken) {
            items.push_back({meant, &entry, place == nullptr, place != nullptr});
        }
    }
    return items;
}

/// Where a protocol can stand that cannot stand here: "inputs", "outputs and [values.NAME]".
std::string homes_of(const Protocol& protocol) {
    const auto join = [](std::string& homes, std::string_view home) {
        homes += (homes.empty() ? "" : " and ") + std::string(home);
    };
    std::string homes;
    if (protocol.has_channels()) {
        join(homes, protocol.goes(SettingScope::input) ? "inputs" : "outputs");
    }
    if (protocol.make_value_reader != nullptr) {
        join(homes, "[values.NAME]");
    }
    if (homes.empty()) {
        join(homes, "[sensor_bus.NAME]");
    }
    return homes;
}

std::optional<SettingValue> read_protocol_name(const TableRef& ref, const Value& value,
                                               Mistakes& mistakes) {
    const auto names = protocol_names(way_of(ref));
    const auto* name = value.as<std::string>();
    if (name == nullptr || std::ranges::find(names, *name) != names.end()) {
        const Setting setting{.key = "protocol", .type = SettingType::choice, .choices = names};
        return read_value({setting}, value, mistakes);
    }
    std::string reason;
    if (const Protocol* protocol = find_protocol(*name)) {
        reason = fmt::format(", which is for {} only", homes_of(*protocol));
    } else if (protocols_meant(*name, names).empty()) {
        for (const std::string_view meant : protocols_meant(*name, protocol_names())) {
            reason += fmt::format(", and {} is for {} only", in_quotes(meant),
                                  homes_of(*find_protocol(meant)));
        }
    }
    mistakes.add(value.where, fmt::format("\"protocol\" is {}{}; {}", in_quotes(*name), reason,
                                          protocol_suggestion(*name, names)));
    return std::nullopt;
}

bool has_value(const Key& key) {
    return key.kind == KeyKind::value || key.kind == KeyKind::protocol;
}

/// The first sentence of its help, and the words that it may be.
std::string meaning_of(const Setting& setting) {
    const std::string_view sentence = setting.help.substr(0, setting.help.find(". "));
    const std::string meaning = without_backticks(sentence);
    return setting.choices.empty() ? meaning
                                   : meaning + ": one of " + in_quotes_all(setting.choices);
}

void report_missing(const TableRef& ref, const Key& key, Reading reading) {
    if (reading.lost.affects(ref.where)) {
        return;
    }
    if (reading.mistakes.full()) {
        reading.mistakes.count();
        return;
    }
    const Protocol* const protocol = find_protocol(ref.protocol);
    if (protocol != nullptr && is_place(key.name())) {
        reading.mistakes.add(
            ref.where, fmt::format("{} lacks {}", ref.title, places_of(*protocol, "; required: ")));
        return;
    }
    const std::string meaning = key.kind == KeyKind::protocol
                                    ? "one of " + in_quotes_all(protocol_names(way_of(ref)))
                                    : meaning_of(key.setting);
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

void TableContent::set_members(void* object, const char* owner, bool only_given) const {
    for (const Key& key : keys_) {
        if (key.field.owner != owner || (only_given && !(given(key.name()) && sound(key.name())))) {
            continue;
        }
        if (const SettingValue* value = values_.find(key.name())) {
            key.field.set(object, *value);
        }
    }
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
            } else if (auto value = default_of(key)) {
                values.set(key.name(), std::move(*value));
            }
        } else if (has_value(key) && !item->other_place) {
            auto value = key.kind == KeyKind::protocol
                             ? read_protocol_name(ref, item->entry->value, reading.mistakes)
                             : read_value(key, item->entry->value, reading.mistakes);
            item->sound = value.has_value();
            if (value) {
                values.set(key.name(), std::move(*value));
            }
        }
    }
    return {ref.where, keys, std::move(items), std::move(values)};
}

std::optional<TableContent> read_only_table(std::string_view name, const Entry* entry,
                                            std::span<const Key> keys, Reading reading) {
    if (entry == nullptr) {
        return std::nullopt;
    }
    const std::string title = fmt::format("[{}]", name);
    const auto* table = entry->value.as<Table>();
    if (table == nullptr) {
        reading.mistakes.add(entry->value.where,
                             fmt::format("{} is {}; allowed: a table, {}", in_quotes(name),
                                         describe(entry->value), title));
        return std::nullopt;
    }
    return read_table({*table, entry->value.where, title}, keys, reading);
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

}  // namespace tribus
