#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/channel_frame.h"
#include "core/setting.h"

/// Tables of a protocol's own keys in which channels stand. Pure and reentrant.
namespace tribus {

/// The entries of the table that a key holds. Null without the key.
inline const SettingTree::Table* table_of(const SettingValues& settings, std::string_view key) {
    const auto* tree = settings.find_as<SettingTree>(key);
    return tree == nullptr ? nullptr : tree->as<SettingTree::Table>();
}

/// An entry with the number of a channel, which counts from 0 here.
inline SettingEntry channel_entry(std::string_view key, std::size_t channel) {
    return {std::string(key), SettingTree{static_cast<std::int64_t>(channel) + 1}};
}

/// The channel that a number from 1 to kChannelCount names, counted from 0. Nothing for others.
inline std::optional<std::size_t> channel_of(const SettingTree& tree) {
    const auto* number = tree.as<std::int64_t>();
    constexpr auto kMost = static_cast<std::int64_t>(kChannelCount);
    const bool fits = number != nullptr && *number >= 1 && *number <= kMost;
    return fits ? std::optional(static_cast<std::size_t>(*number) - 1) : std::nullopt;
}

}  // namespace tribus
