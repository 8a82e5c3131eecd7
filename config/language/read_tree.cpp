#include "config/language/read_tree.h"

#include <fmt/format.h>

#include <filesystem>
#include <string>
#include <type_traits>
#include <utility>

#include "config/language/read_file.h"
#include "core/quotes.h"

namespace tribus {
namespace {

/// Far more than any DBC file of a vehicle has.
constexpr std::size_t kMostFileBytes = 16UL * 1024UL * 1024UL;

std::optional<SettingTree> convert(std::string_view key, const Value& value, Mistakes& mistakes);

std::optional<SettingTree> convert_list(std::string_view key, const List& list,
                                        Mistakes& mistakes) {
    SettingTree::List items;
    for (const Value& item : list.items) {
        if (auto tree = convert(key, item, mistakes)) {
            items.push_back(std::move(*tree));
        }
    }
    const bool whole = items.size() == list.items.size();
    return whole ? std::optional(SettingTree{std::move(items)}) : std::nullopt;
}

std::optional<SettingTree> convert_table(const Table& table, Mistakes& mistakes) {
    SettingTree::Table entries;
    for (const Entry& entry : table.entries) {
        if (auto tree = convert(entry.key, entry.value, mistakes)) {
            entries.push_back({entry.key, std::move(*tree)});
        }
    }
    const bool whole = entries.size() == table.entries.size();
    return whole ? std::optional(SettingTree{std::move(entries)}) : std::nullopt;
}

/// The TOML parser limits the depth.
std::optional<SettingTree> convert(std::string_view key, const Value& value, Mistakes& mistakes) {
    return std::visit(
        [&](const auto& content) -> std::optional<SettingTree> {
            using Content = std::decay_t<decltype(content)>;
            if constexpr (std::is_same_v<Content, List>) {
                return convert_list(key, content, mistakes);
            } else if constexpr (std::is_same_v<Content, Table>) {
                return convert_table(content, mistakes);
            } else if constexpr (std::is_same_v<Content, DateOrTime>) {
                mistakes.add(value.where,
                             fmt::format("{} is a date or time; allowed: a number, true or false, "
                                         "text, a list or a table",
                                         in_quotes(key)));
                return std::nullopt;
            } else {
                return SettingTree{content};
            }
        },
        value.content);
}

}  // namespace

std::optional<SettingTree> read_tree(std::string_view key, const Value& value, Mistakes& mistakes) {
    if (value.as<Table>() == nullptr) {
        mistakes.add(value.where,
                     fmt::format("{} is {}; allowed: a table", in_quotes(key), describe(value)));
        return std::nullopt;
    }
    return convert(key, value, mistakes);
}

std::optional<SettingFile> read_named_file(std::string_view key, const Value& value,
                                           Mistakes& mistakes) {
    const auto sentence = [&](std::string_view reason) {
        return fmt::format(
            "{} is {}: {}; allowed: the path of a text file, relative to the folder of this file",
            in_quotes(key), describe(value), reason);
    };
    const auto refuse = [&](std::string_view reason) {
        mistakes.add(value.where, sentence(reason));
        return std::nullopt;
    };
    const auto* name = value.as<std::string>();
    if (name == nullptr || name->empty()) {
        return refuse("not the path of a file");
    }
    const std::filesystem::path path = std::filesystem::path(mistakes.file()).parent_path() / *name;
    auto content = read_file(path, kMostFileBytes + 1);
    if (!content) {
        mistakes.add_out_of_reach(value.where, sentence(content.error()));
        return std::nullopt;
    }
    if (content->size() > kMostFileBytes) {
        return refuse("larger than 16 MiB");
    }
    content->shrink_to_fit();
    return SettingFile{*name, std::move(*content)};
}

}  // namespace tribus
