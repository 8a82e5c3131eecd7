#include "config/keys/keys.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

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

std::vector<std::string> names_of(std::span<const Key> keys) {
    std::vector<std::string> names;
    for (const Key& key : keys) {
        names.emplace_back(key.name());
    }
    return names;
}

using Names = std::vector<std::string>;

TEST(KeysOfAProtocol, AreThoseOfItsPlaceItsMediumAndItsOwn) {
    const Protocol& sbus = *find_protocol("sbus");
    const Protocol& can = *find_protocol("can");
    const auto on = [](const Protocol& protocol, std::size_t medium, SettingScope way) {
        return names_of(protocol_keys(protocol, *media_for(protocol).at(medium), way));
    };
    EXPECT_EQ(on(sbus, 0, SettingScope::input), (Names{"device", "baud", "scale", "inverted"}));
    EXPECT_EQ(on(sbus, 1, SettingScope::input), (Names{"address", "public", "sender", "scale"}));
    EXPECT_EQ(on(sbus, 1, SettingScope::output), (Names{"address", "public", "scale"}));
    EXPECT_EQ(on(sbus, 2, SettingScope::output), (Names{"spi", "baud", "scale", "inverted"}));
    EXPECT_EQ(on(can, 0, SettingScope::input),
              (Names{"interface", "id", "extended", "fd", "crc", "channels", "key", "old_key",
                     "link", "epoch"}));
    EXPECT_EQ(on(can, 0, SettingScope::output).at(1), "foreign_sender");
}

TEST(KeysOfAProtocol, RequireNoPlaceWhereThereAreSeveralMedia) {
    const auto sbus = protocol_keys(*find_protocol("sbus"), SettingScope::input);
    EXPECT_EQ(names_of(sbus),
              (Names{"device", "address", "spi", "public", "sender", "baud", "scale", "inverted"}));
    EXPECT_FALSE(sbus[0].setting.required);
    EXPECT_FALSE(sbus[1].setting.required);
    const auto can = protocol_keys(*find_protocol("can"), SettingScope::output);
    EXPECT_EQ(names_of(can).at(0), "interface");
    EXPECT_EQ(names_of(can).at(1), "foreign_sender");
    EXPECT_TRUE(can[0].setting.required);
}

TEST(KeyTable, NamesTheProtocolsOfEachWay) {
    Names all;
    for (const Protocol* protocol : protocols()) {
        all.emplace_back(protocol->name);
    }
    const auto names = protocol_names();
    EXPECT_EQ(Names(names.begin(), names.end()), all);
    for (const Protocol* protocol : protocols()) {
        const auto in = protocol_names(SettingScope::input);
        const auto out = protocol_names(SettingScope::output);
        EXPECT_EQ(std::ranges::count(in, protocol->name), protocol->make_decoder != nullptr ? 1 : 0)
            << protocol->name;
        EXPECT_EQ(std::ranges::count(out, protocol->name),
                  protocol->make_encoder != nullptr ? 1 : 0)
            << protocol->name;
    }
}

TEST(DefaultOfAKey, IsThatOfTheRowOrElseThatOfItsMember) {
    EXPECT_EQ(default_of(key_named(runtime_keys(), "priority")), SettingValue(std::int64_t{80}));
    EXPECT_EQ(default_of(key_named(runtime_keys(), "cpu")), std::nullopt);
    EXPECT_EQ(
        default_of(Key{.setting = {.key = "k", .type = SettingType::integer, .fallback = "5"}}),
        SettingValue(std::int64_t{5}));
    EXPECT_EQ(default_of(Key{.setting = {.key = "k", .type = SettingType::integer}}), std::nullopt);
    Key key = key_named(runtime_keys(), "priority");
    key.setting.required = true;
    EXPECT_EQ(default_of(key), std::nullopt);
    key.setting.required = false;
    key.setting.absent = "as it is";
    EXPECT_EQ(default_of(key), std::nullopt);
    key.setting.fallback = "7";
    EXPECT_EQ(default_of(key), SettingValue(std::int64_t{7}));
}

TEST(AllowedValues, AreWhatTheNamesOfFilesAndTablesMean) {
    const auto allowed = [](SettingType type) {
        return allowed_values({Setting{.key = "x", .type = type}});
    };
    EXPECT_EQ(allowed(SettingType::file), "the path of a text file");
    EXPECT_EQ(allowed(SettingType::key_file), "the path of a key file");
    EXPECT_EQ(allowed(SettingType::tree), "a table");
}

}  // namespace
}  // namespace tribus::test::keys_test
