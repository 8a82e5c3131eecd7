#include <gtest/gtest.h>
#include <pthread.h>

#include <algorithm>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "config/language/key_parts.h"
#include "config/language/parse_toml.h"
#include "config/load.h"

namespace tribus::test::depth_test {
namespace {

std::string repeated(std::string_view text, std::size_t count) {
    std::string all;
    for (std::size_t i = 0; i < count; ++i) {
        all += text;
    }
    return all;
}

std::vector<std::string> mistakes_in(const std::string& text) {
    std::vector<std::string> told;
    const auto configuration = load_configuration(text, "t.toml");
    if (!configuration) {
        for (const Mistake& mistake : configuration.error()) {
            told.push_back(format_mistake(mistake));
        }
    }
    return told;
}

/// 45 kB of such keys overflowed a stack of 8 MiB.
constexpr std::size_t kDeep = 22'800;

/// `before`, then `parts` times `part`, then `after`. The test puts it together, because every run
/// of this program makes the parameters of all tests.
struct DeepText {
    std::string name;
    std::string before;
    std::string part;
    std::size_t parts;
    std::string after;
    std::string place;  ///< of the first part beyond the limit

    [[nodiscard]] std::string text() const { return before + repeated(part, parts) + after; }
};

class KeyOfManyParts : public ::testing::TestWithParam<DeepText> {};

TEST_P(KeyOfManyParts, IsAMistakeWithItsPlace) {
    const auto mistakes = mistakes_in(GetParam().text());
    EXPECT_EQ(
        std::ranges::count(mistakes, "t.toml:" + GetParam().place +
                                         ": this key has too many parts; allowed: at most 16"),
        1)
        << ::testing::PrintToString(mistakes);
}

INSTANTIATE_TEST_SUITE_P(
    Each, KeyOfManyParts,
    ::testing::Values(DeepText{"dotted", "\n", "a.", kDeep, "a = 1\n", "2:33"},
                      DeepText{"header", "[", "a.", kDeep, "a]\n", "1:34"},
                      DeepText{"header_of_tables", "[[", "a.", kDeep, "a]]\n", "1:35"},
                      DeepText{"inline", "x = { ", "a.", kDeep, "a = 1 }\n", "1:39"},
                      DeepText{"quoted", "", "\"a.#\".", kDeep, "a = 1\n", "1:97"},
                      DeepText{"with_blanks", "", "'a' . ", kDeep, "a = 1\n", "1:96"},
                      DeepText{"behind_text_of_several_lines",
                               "x = \"\"\"\n\"\" \\\"\"\" .\n\"\"\"\"\n", "a.", kDeep, "a = 1\n",
                               "4:33"},
                      DeepText{"seventeen", "", "a.", 16, "a = 1\n", "1:33"}),
    [](const auto& deep) { return deep.param.name; });

TEST(Depth, IsNoMistakeWithSixteenParts) {
    const auto mistakes = mistakes_in(repeated("a.", 15) + "a = 1\n");
    ASSERT_FALSE(mistakes.empty());
    EXPECT_EQ(mistakes.front().find("parts"), std::string::npos) << mistakes.front();
}

TEST(Depth, IsNotCountedInTextsAndComments) {
    const std::string dots = repeated("a.", 100);
    for (const std::string& text : std::vector<std::string>{
             "# " + dots, "x = \"" + dots + "\"", "x = '" + dots + "'",
             "x = '''\n" + dots + "'\n" + dots + "'''", "x = \"\\\"" + dots + "\"",
             "x = [1.5, 1.5, 1.5, 1.5, 1.5, 1.5, 1.5, 1.5, 1.5, 1.5, 1.5, 1.5, 1.5, 1.5, 1.5, "
             "1.5]"}) {
        EXPECT_FALSE(find_key_of_too_many_parts(text)) << text;
    }
}

/// Everything that TOML can nest, each as deep as allowed.
std::string deepest() {
    const std::string key = repeated("a.", kMostKeyParts - 1) + "a";
    const std::size_t levels = 31;
    return "[" + key + "]\n" + key + " = " + repeated("{ " + key + " = ", levels) + "1" +
           repeated(" }", levels) + "\n";
}

TEST(Depth, ThatIsAllowedFitsIntoAStackOfOneMebibyte) {
    const std::string text = deepest();
    ASSERT_TRUE(parse_toml(text));
    pthread_attr_t attributes;
    ASSERT_EQ(::pthread_attr_init(&attributes), 0);
    ASSERT_EQ(::pthread_attr_setstacksize(&attributes, 1024UL * 1024UL), 0);
    std::vector<std::string> mistakes;
    std::function<void()> work = [&] { mistakes = mistakes_in(text); };
    pthread_t thread{};
    ASSERT_EQ(::pthread_create(
                  &thread, &attributes,
                  [](void* given) -> void* {
                      (*static_cast<std::function<void()>*>(given))();
                      return nullptr;
                  },
                  &work),
              0);
    ::pthread_join(thread, nullptr);
    ::pthread_attr_destroy(&attributes);
    EXPECT_FALSE(mistakes.empty());
}

TEST(Depth, IsLimitedForListsAndTablesInEachOtherToo) {
    for (const char* opening : {"[", "{ a = "}) {
        const auto mistakes = mistakes_in("x = " + repeated(opening, kDeep) + "\n");
        ASSERT_FALSE(mistakes.empty());
        EXPECT_NE(mistakes.front().find("more than 32 nested lists and tables"), std::string::npos)
            << mistakes.front();
    }
}

}  // namespace
}  // namespace tribus::test::depth_test
