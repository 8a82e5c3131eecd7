#include "config/keys/keys.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

#include "config/read/value.h"
#include "config/schema/notation.h"
#include "transports/registry/registry.h"

namespace tribus::test::keys_test {
namespace {

void collect(std::span<const Key> keys, std::vector<Key>& all) {
    for (const Key& key : keys) {
        all.push_back(key);
        collect(key.inside, all);
    }
}

std::vector<Key> every_key() {
    std::vector<Key> all;
    collect(root_keys(), all);
    for (const Protocol* protocol : protocols()) {
        for (const SettingScope scope : {SettingScope::input, SettingScope::output}) {
            const auto own = protocol_keys(*protocol, scope);
            all.insert(all.end(), own.begin(), own.end());
        }
    }
    return all;
}

/// Returns a default as the parser of a file would return it.
Value as_written(const Setting& setting) {
    const SettingValue value = default_of(setting);
    Value written;
    if (const auto* truth = std::get_if<bool>(&value)) {
        written.content = *truth;
    } else if (const auto* whole = std::get_if<std::int64_t>(&value)) {
        written.content = *whole;
    } else if (const auto* number = std::get_if<double>(&value)) {
        written.content = *number;
    } else if (const auto* range = std::get_if<NumberRange>(&value)) {
        List ends;
        for (const double end : {range->low, range->high}) {
            ends.items.emplace_back().content = end;
        }
        written.content = ends;
    } else {
        written.content = std::string(unquoted_fallback(setting));
    }
    return written;
}

TEST(KeyTable, EveryDefaultIsAllowedByItsOwnRow) {
    for (const Key& key : every_key()) {
        if (!key.setting.fallback.empty()) {
            Mistakes mistakes("t.toml");
            const auto value = read_value(key.setting, as_written(key.setting), mistakes);
            ASSERT_TRUE(mistakes.empty()) << key.name() << ": " << mistakes.sorted().front().text;
            EXPECT_EQ(*value, default_of(key.setting)) << key.name();
        }
    }
}

TEST(KeyTable, TextualDefaultsStandInQuotesAsInAFile) {
    for (const Key& key : every_key()) {
        const SettingType type = key.setting.type;
        const bool bare = type == SettingType::boolean || type == SettingType::integer ||
                          type == SettingType::number || type == SettingType::pulse ||
                          type == SettingType::pulses;
        if (!key.setting.fallback.empty()) {
            EXPECT_EQ(key.setting.fallback.starts_with('"'), !bare) << key.name();
        }
    }
}

TEST(KeyTable, EveryKeySaysWhatItIsFor) {
    for (const Key& key : every_key()) {
        EXPECT_FALSE(key.setting.help.empty()) << key.name();
    }
}

TEST(KeyTable, NoKeyStandsTwiceInOneTable) {
    for (const Key& table : root_keys()) {
        for (const Protocol* protocol : protocols()) {
            std::vector<Key> keys(table.inside.begin(), table.inside.end());
            if (table.protocol_scope) {
                const auto own = protocol_keys(*protocol, *table.protocol_scope);
                keys.insert(keys.end(), own.begin(), own.end());
            }
            std::set<std::string_view> names;
            for (const Key& key : keys) {
                EXPECT_TRUE(names.insert(key.name()).second) << table.name() << '.' << key.name();
            }
        }
    }
}

TEST(KeyTable, ShapingAndSourceKeysAreChannelKeys) {
    for (const std::string_view name : shaping_key_names()) {
        EXPECT_EQ(key_named(channel_keys(), name).name(), name);
    }
    for (const std::string_view name : channel_source_names()) {
        EXPECT_EQ(key_named(channel_keys(), name).name(), name);
    }
}

}  // namespace
}  // namespace tribus::test::keys_test
