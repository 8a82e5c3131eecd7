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
Value as_written(const Setting& setting, const SettingValue& value) {
    Value written_value;
    if (const auto* truth = std::get_if<bool>(&value)) {
        written_value.content = *truth;
    } else if (const auto* whole = std::get_if<std::int64_t>(&value)) {
        written_value.content = *whole;
    } else if (const auto* range = std::get_if<NumberRange>(&value)) {
        List ends;
        for (const double end : {range->low, range->high}) {
            ends.items.emplace_back().content = end;
        }
        written_value.content = ends;
    } else if (const auto* number = std::get_if<double>(&value);
               number != nullptr && setting.type != SettingType::slew) {
        written_value.content = *number;
    } else {
        const std::string text = written(setting.type, value);
        written_value.content = text.substr(1, text.size() - 2);
    }
    return written_value;
}

TEST(KeyTable, EveryDefaultIsAllowedByItsOwnRow) {
    int defaults = 0;
    for (const Key& key : every_key()) {
        if (const auto value = default_of(key)) {
            Mistakes mistakes("t.toml");
            const auto read = read_value(key, as_written(key.setting, *value), mistakes);
            ASSERT_TRUE(mistakes.empty()) << key.name() << ": " << mistakes.sorted().front().text;
            EXPECT_EQ(*read, *value) << key.name();
            ++defaults;
        }
    }
    EXPECT_GT(defaults, 40);
}

TEST(KeyTable, TextualDefaultsStandInQuotesAsInAFile) {
    for (const Key& key : every_key()) {
        const SettingType type = key.setting.type;
        const bool bare = type == SettingType::boolean || type == SettingType::integer ||
                          type == SettingType::number || type == SettingType::pulse ||
                          type == SettingType::pulses;
        if (const auto value = default_of(key)) {
            EXPECT_EQ(written(type, *value).starts_with('"'), !bare) << key.name();
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
