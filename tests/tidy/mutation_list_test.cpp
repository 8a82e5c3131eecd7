#include <gtest/gtest.h>

#include <cstddef>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "config/language/parse_toml.h"
#include "config/language/read_file.h"

/// The list of tests/mutation stays true while the sources change.
namespace tribus::test::mutation_list_test {
namespace {

constexpr std::size_t kMostBytes = 1 << 20;

struct Mutation {
    std::string name;
    std::string file;
    std::string text;
    std::string instead;
};

std::string word(const Table& table, std::string_view key) {
    const Entry* entry = table.find(key);
    const std::string* text = entry != nullptr ? entry->value.as<std::string>() : nullptr;
    return text != nullptr ? *text : std::string{};
}

std::string source(const std::string& file) {
    return read_file(std::string(TRIBUS_SOURCE_DIR) + "/" + file, kMostBytes).value_or("");
}

std::vector<Mutation> mutations() {
    std::vector<Mutation> all;
    const auto list = parse_toml(source("tests/mutation/mutations.toml"));
    const Entry* entries = list ? list->find("mutation") : nullptr;
    const List* tables = entries != nullptr ? entries->value.as<List>() : nullptr;
    if (tables != nullptr) {
        for (const Value& value : tables->items) {
            const Table& table = *value.as<Table>();
            all.push_back({word(table, "name"), word(table, "file"), word(table, "text"),
                           word(table, "instead")});
        }
    }
    return all;
}

TEST(MutationList, HasAtLeastForty) {
    EXPECT_GE(mutations().size(), 40U);
}

TEST(MutationList, WhatIsChangedStandsExactlyOnceInItsFile) {
    for (const Mutation& mutation : mutations()) {
        const std::string text = source(mutation.file);
        const std::size_t first = text.find(mutation.text);
        EXPECT_NE(first, std::string::npos) << mutation.name;
        EXPECT_EQ(first, text.rfind(mutation.text)) << mutation.name;
    }
}

TEST(MutationList, WhatStandsThereInsteadIsSomethingElse) {
    for (const Mutation& mutation : mutations()) {
        EXPECT_NE(mutation.text, mutation.instead) << mutation.name;
    }
}

TEST(MutationList, EachWasNoticedByATest) {
    const std::string record = source("tests/mutation/caught.md");
    for (const Mutation& mutation : mutations()) {
        EXPECT_NE(record.find("| " + mutation.name + " | `" + mutation.file + "` | `"),
                  std::string::npos)
            << "run: tests/mutation/run.sh --record \"" << mutation.name << "\"";
    }
}

TEST(MutationList, NamesTellMutationsApart) {
    std::set<std::string> names;
    for (const Mutation& mutation : mutations()) {
        EXPECT_TRUE(names.insert(mutation.name).second) << mutation.name;
    }
}

}  // namespace
}  // namespace tribus::test::mutation_list_test
