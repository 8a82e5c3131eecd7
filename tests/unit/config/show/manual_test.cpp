#include "config/show/manual.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "config/show/manual_sections.h"
#include "config/show/manual_text.h"
#include "tests/unit/config/examples.h"
#include "transports/registry/registry.h"

namespace tribus::test::manual_test {
namespace {

bool shows(const ManualSection& section, const Key& key) {
    return std::ranges::any_of(section.keys, [&](const Key& row) {
        return row.name() == key.name() &&
               row.setting.help.find(key.setting.help) != std::string_view::npos;
    });
}

/// One section has all of them.
void expect_together(std::span<const Key> keys, std::string_view table) {
    const auto sections = manual_sections();
    EXPECT_TRUE(std::ranges::any_of(sections, [&](const ManualSection& section) {
        return std::ranges::all_of(keys, [&](const Key& key) { return shows(section, key); });
    })) << table;
}

void expect_below(std::span<const Key> keys) {
    for (const Key& key : keys) {
        if (!key.inside.empty()) {
            expect_together(key.inside, key.name());
            expect_below(key.inside);
        }
    }
}

TEST(Manual, HasEveryKeyOfEveryTable) {
    expect_below(root_keys());
}

TEST(Manual, HasEveryKeyOfEveryProtocol) {
    for (const Protocol* protocol : protocols()) {
        for (const SettingScope way : {SettingScope::input, SettingScope::output}) {
            for (const Key& key : protocol_keys(*protocol, way)) {
                expect_together(std::span(&key, 1), protocol->name);
            }
        }
        for (const Setting& setting : protocol->settings) {
            for (const Setting& inside : setting.inside) {
                const Key key{inside};
                expect_together(std::span(&key, 1), protocol->name);
            }
        }
    }
}

TEST(Manual, NamesEachAnchorOnce) {
    std::set<std::string> anchors;
    for (const ManualSection& section : manual_sections()) {
        for (const Key& key : section.keys) {
            const std::string anchor = section.anchor + "-" + std::string(key.name());
            EXPECT_TRUE(anchors.insert(anchor).second) << anchor;
        }
    }
    EXPECT_GT(anchors.size(), 150U);
}

TEST(Manual, ShowsTypeRangeDefaultMeaningAndExampleOfAKey) {
    const std::string page = manual_markdown();
    EXPECT_NE(page.find("| <a id=\"input-timeout\"></a>`timeout` | duration | `\"5ms\"` to "
                        "`\"10s\"` | `\"100ms\"` | The input is lost when no good frame has come "
                        "for this long."),
              std::string::npos);
    EXPECT_NE(page.find("| `timeout = \"250ms\"` |\n"), std::string::npos);
}

TEST(ManualText, IsParagraphsListsAndCode) {
    const auto blocks = blocks_of("One\nline.\n\n- a\n  b\n- c\n\n```toml\nd = 1\n\ne = 2\n```\n");
    ASSERT_EQ(blocks.size(), 3U);
    EXPECT_EQ(blocks[0].texts, std::vector<std::string>{"One line."});
    EXPECT_EQ(blocks[1].texts, (std::vector<std::string>{"a b", "c"}));
    EXPECT_EQ(blocks[2].kind, BlockKind::code);
    EXPECT_EQ(blocks[2].texts, (std::vector<std::string>{"d = 1", "", "e = 2"}));
}

}  // namespace
}  // namespace tribus::test::manual_test
