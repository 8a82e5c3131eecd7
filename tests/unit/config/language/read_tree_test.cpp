#include "config/language/read_tree.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "config/language/parse_toml.h"
#include "tests/support/temporary_folder.h"

namespace tribus::test::read_tree_test {
namespace {

using Lines = std::vector<std::string>;

/// Reads the value of the only key, `key`, of a configuration in its own folder.
class ReadTree : public ::testing::Test {
  protected:
    std::optional<SettingTree> tree(std::string_view toml) {
        return read("key = " + std::string(toml), read_tree);
    }
    std::optional<SettingFile> file(std::string_view toml) {
        return read("key = " + std::string(toml), read_named_file);
    }
    /// Returns the mistakes as "line:column: text".
    Lines mistakes() const {
        Lines lines;
        for (const Mistake& mistake : mistakes_.sorted()) {
            lines.push_back(format_mistake({"f", mistake.where, mistake.text}).substr(2));
        }
        return lines;
    }

    const TemporaryFolder folder_;

  private:
    template <class Result>
    std::optional<Result> read(const std::string& text,
                               std::optional<Result> (*reader)(std::string_view, const Value&,
                                                               Mistakes&)) {
        const auto table = parse_toml(text);
        if (!table) {
            ADD_FAILURE() << table.error().text;
            return std::nullopt;
        }
        return reader("key", table->entries.front().value, mistakes_);
    }

    Mistakes mistakes_{folder_ / "t.toml"};
};

TEST_F(ReadTree, KeepsEveryKindOfValueAndTheOrderOfTheFile) {
    const auto read = tree(R"({ z = true, a = [1, -2.5, "text"], m = { inner = [] } })");
    ASSERT_TRUE(read);
    const auto* entries = read->as<SettingTree::Table>();
    ASSERT_NE(entries, nullptr);
    const SettingTree::Table expected{
        {"z", {true}},
        {"a", {SettingTree::List{{std::int64_t{1}}, {-2.5}, {std::string("text")}}}},
        {"m", {SettingTree::Table{{"inner", {SettingTree::List{}}}}}},
    };
    EXPECT_EQ(*entries, expected);
    EXPECT_EQ(mistakes(), Lines{});
}

TEST_F(ReadTree, RefusesWhatIsNoTable) {
    EXPECT_FALSE(tree("5"));
    EXPECT_EQ(mistakes(), Lines{"1:7: \"key\" is 5; allowed: a table"});
}

TEST_F(ReadTree, RefusesAListAsTheWhole) {
    EXPECT_FALSE(tree("[{ a = 1 }]"));
    EXPECT_EQ(mistakes(), Lines{"1:7: \"key\" is a list; allowed: a table"});
}

TEST_F(ReadTree, NamesEveryDateInsideByTheKeyThatItStandsUnder) {
    EXPECT_FALSE(tree("{ a = 1979-05-27, b = { c = [1, 07:32:00] }, d = 1 }"));
    EXPECT_EQ(mistakes(), (Lines{"1:13: \"a\" is a date or time; allowed: a number, true or false, "
                                 "text, a list or a table",
                                 "1:39: \"c\" is a date or time; allowed: a number, true or false, "
                                 "text, a list or a table"}));
}

TEST_F(ReadTree, ReadsTheNamedFileWithItsBytesAsTheyAre) {
    const std::string content("a\r\n\0\xFF", 5);
    folder_.write("bus.dbc", content);
    const auto read = file("\"bus.dbc\"");
    ASSERT_TRUE(read);
    EXPECT_EQ(read->path, "bus.dbc");
    EXPECT_EQ(read->content, content);
}

TEST_F(ReadTree, SeeksTheFileFromTheFolderOfTheConfiguration) {
    std::filesystem::create_directory(folder_ / "inside");
    folder_.write("inside/bus.dbc", "x");
    EXPECT_TRUE(file("\"inside/bus.dbc\""));
    EXPECT_TRUE(file("\"inside/../inside/bus.dbc\""));
    const std::string absolute = "'" + (folder_ / "inside/bus.dbc") + "'";
    EXPECT_TRUE(file(absolute));
}

TEST_F(ReadTree, ReadsAnEmptyFile) {
    folder_.write("empty.dbc", "");
    const auto read = file("\"empty.dbc\"");
    ASSERT_TRUE(read);
    EXPECT_EQ(read->content, "");
}

TEST_F(ReadTree, SaysThatAFileIsMissing) {
    EXPECT_FALSE(file("\"none.dbc\""));
    EXPECT_EQ(mistakes(), Lines{"1:7: \"key\" is \"none.dbc\": No such file or directory; allowed: "
                                "the path of a text file, relative to the folder of this file"});
}

TEST_F(ReadTree, SaysThatAFolderIsNoFile) {
    std::filesystem::create_directory(folder_ / "inside");
    EXPECT_FALSE(file("\"inside\""));
    EXPECT_EQ(mistakes(), Lines{"1:7: \"key\" is \"inside\": it is a folder; allowed: the path of "
                                "a text file, relative to the folder of this file"});
}

TEST_F(ReadTree, NeverReadsADeviceThatHasNoEnd) {
    EXPECT_FALSE(file("\"/dev/zero\""));
    EXPECT_EQ(mistakes(),
              Lines{"1:7: \"key\" is \"/dev/zero\": it is a device or a pipe, not a file; allowed: "
                    "the path of a text file, relative to the folder of this file"});
}

TEST_F(ReadTree, RefusesAFileBeyond16MiBAndTakesOneOf16) {
    folder_.write("big.dbc", "");
    constexpr std::uintmax_t kMost = 16U * 1024 * 1024;
    std::filesystem::resize_file(folder_ / "big.dbc", kMost);
    EXPECT_TRUE(file("\"big.dbc\""));
    std::filesystem::resize_file(folder_ / "big.dbc", kMost + 1);
    EXPECT_FALSE(file("\"big.dbc\""));
    EXPECT_EQ(mistakes(), Lines{"1:7: \"key\" is \"big.dbc\": larger than 16 MiB; allowed: the "
                                "path of a text file, relative to the folder of this file"});
}

TEST_F(ReadTree, RefusesAPathThatIsNoText) {
    EXPECT_FALSE(file("5"));
    EXPECT_FALSE(file("\"\""));
    EXPECT_EQ(mistakes(), (Lines{"1:7: \"key\" is 5: not the path of a file; allowed: the path of "
                                 "a text file, relative to the folder of this file",
                                 "1:7: \"key\" is \"\": not the path of a file; allowed: the path "
                                 "of a text file, relative to the folder of this file"}));
}

}  // namespace
}  // namespace tribus::test::read_tree_test
