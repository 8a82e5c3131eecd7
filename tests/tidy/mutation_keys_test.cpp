#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <set>
#include <string>
#include <string_view>

#include "config/language/parse_toml.h"
#include "config/language/read_file.h"

/// tests/mutation/equivalent.toml: made mutations that change nothing.
namespace tribus::test::mutation_keys_test {
namespace {

constexpr std::size_t kMostBytes = 1 << 20;
constexpr std::size_t kKeyLength = 10;
constexpr std::size_t kShortestReason = 20;

std::string word(const Table& table, std::string_view key) {
    const Entry* entry = table.find(key);
    const std::string* text = entry != nullptr ? entry->value.as<std::string>() : nullptr;
    return text != nullptr ? *text : std::string{};
}

TEST(EquivalentMutations, EachHasAKeyOfItsOwnAFileThatIsThereAndAReason) {
    const std::string root = std::string(TRIBUS_SOURCE_DIR) + "/";
    const auto list =
        parse_toml(read_file(root + "tests/mutation/equivalent.toml", kMostBytes).value_or(""));
    ASSERT_TRUE(list);
    const Entry* entries = list->find("equivalent");
    ASSERT_NE(entries, nullptr);
    std::set<std::string> keys;
    for (const Value& value : entries->value.as<List>()->items) {
        const Table& table = *value.as<Table>();
        const std::string key = word(table, "key");
        EXPECT_EQ(key.size(), kKeyLength) << key;
        EXPECT_TRUE(std::ranges::all_of(key, [](unsigned char letter) {
            return std::isxdigit(letter) != 0;
        })) << key;
        EXPECT_TRUE(keys.insert(key).second) << key;
        EXPECT_TRUE(read_file(root + word(table, "file"), kMostBytes)) << key;
        EXPECT_FALSE(word(table, "change").empty()) << key;
        EXPECT_GE(word(table, "why").size(), kShortestReason) << key;
    }
}

}  // namespace
}  // namespace tribus::test::mutation_keys_test
