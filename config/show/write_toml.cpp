#include "config/show/write_toml.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <string_view>

#include "core/quotes.h"

namespace tribus {
namespace {

using Json = nlohmann::ordered_json;

std::string inline_toml(const Json& json) {
    std::string text;
    if (json.is_string()) {
        return in_quotes(json.get<std::string>());
    }
    if (json.is_array()) {
        for (const Json& item : json) {
            text += (text.empty() ? "" : ", ") + inline_toml(item);
        }
        return "[" + text + "]";
    }
    if (json.is_object()) {
        for (const auto& [key, value] : json.items()) {
            text += fmt::format("{}{} = {}", text.empty() ? " " : ", ", key, inline_toml(value));
        }
        return "{" + text + " }";
    }
    return json.dump();
}

const Key* header_key(std::span<const Key> keys, std::string_view name) {
    const auto key = std::find_if(keys.begin(), keys.end(),
                                  [name](const Key& row) { return row.name() == name; });
    const bool header =
        key != keys.end() && (key->kind == KeyKind::table || key->kind == KeyKind::named_tables ||
                              key->kind == KeyKind::channels);
    return header ? &*key : nullptr;
}

/// Writes the lines of a table, then the tables inside it.
void write_table(const Json& json, std::span<const Key> keys, const std::string& path,
                 std::string& out) {
    std::string lines;
    for (const auto& [name, value] : json.items()) {
        if (header_key(keys, name) == nullptr) {
            lines += fmt::format("{} = {}\n", name, inline_toml(value));
        }
    }
    if (!lines.empty()) {
        out += fmt::format("{}[{}]\n{}", out.empty() ? "" : "\n", path, lines);
    }
    for (const auto& [name, value] : json.items()) {
        const Key* key = header_key(keys, name);
        if (key == nullptr) {
            continue;
        }
        const std::string inside = path.empty() ? name : fmt::format("{}.{}", path, name);
        if (key->kind == KeyKind::named_tables) {
            for (const auto& [user_name, table] : value.items()) {
                write_table(table, key->inside, fmt::format("{}.{}", inside, user_name), out);
            }
        } else {
            // The entries of `channels` are written in one line each.
            const bool channels = key->kind == KeyKind::channels;
            write_table(value, channels ? std::span<const Key>{} : key->inside, inside, out);
        }
    }
}

}  // namespace

std::string write_toml(const Json& json, std::span<const Key> keys) {
    std::string text;
    write_table(json, keys, {}, text);
    return text;
}

}  // namespace tribus
