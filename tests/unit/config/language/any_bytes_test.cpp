#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "config/load.h"
#include "config/show/effective.h"
#include "tests/unit/config/examples.h"

namespace tribus::test::any_bytes_test {
namespace {

/// Checks that the text loads, or that each mistake is one line with a place and a reason.
void expect_an_answer(const std::string& text) {
    const auto configuration = load_configuration(text, "t.toml");
    if (configuration) {
        const auto again = load_configuration(effective_toml(*configuration), "t.toml");
        RC_ASSERT(again.has_value());
        RC_ASSERT(effective_toml(*again) == effective_toml(*configuration));
        return;
    }
    RC_ASSERT(!configuration.error().empty());
    for (const Mistake& mistake : configuration.error()) {
        RC_ASSERT(mistake.where.line >= 1U);
        RC_ASSERT(mistake.where.column >= 1U);
        RC_ASSERT(!mistake.text.empty());
        RC_ASSERT(mistake.text.find('\n') == std::string::npos);
    }
}

std::string any_example() {
    static const auto files = example_files();
    return content_of(*rc::gen::elementOf(files));
}

RC_GTEST_PROP(AnyBytes, GetAnAnswer, ()) {
    expect_an_answer(*rc::gen::container<std::string>(rc::gen::arbitrary<char>()));
}

RC_GTEST_PROP(AnyBytes, WithTomlPunctuationGetAnAnswer, ()) {
    expect_an_answer(*rc::gen::container<std::string>(
        rc::gen::elementOf(std::string("[]{}=.,\"'\n# 18abinput-_\\"))));
}

RC_GTEST_PROP(SpoiltExamples, WithOneByteReplacedGetAnAnswer, ()) {
    std::string text = any_example();
    text[*rc::gen::inRange<std::size_t>(0, text.size())] = *rc::gen::arbitrary<char>();
    expect_an_answer(text);
}

RC_GTEST_PROP(SpoiltExamples, WithAPieceLeftOutGetAnAnswer, ()) {
    std::string text = any_example();
    const auto begin = *rc::gen::inRange<std::size_t>(0, text.size());
    text.erase(begin, *rc::gen::inRange<std::size_t>(1, 40));
    expect_an_answer(text);
}

RC_GTEST_PROP(SpoiltExamples, WithTwoLinesSwappedGetAnAnswer, ()) {
    std::string text = any_example();
    std::vector<std::string> lines;
    for (std::size_t end = text.find('\n'); end != std::string::npos; end = text.find('\n')) {
        lines.push_back(text.substr(0, end + 1));
        text.erase(0, end + 1);
    }
    const auto line = rc::gen::inRange<std::size_t>(0, lines.size());
    std::swap(lines[*line], lines[*line]);
    for (const std::string& part : lines) {
        text += part;
    }
    expect_an_answer(text);
}

RC_GTEST_PROP(SpoiltExamples, WithAnotherValueGetAnAnswer, ()) {
    static const std::vector<std::string> values{
        "nan",  "-inf",     "9223372036854775807", "-1",         "\"\"",        "[]",
        "{}",   "[[]]",     "1979-05-27",          "{ 1 = {} }", "\"\\u0000\"", "0.0000001",
        "true", "\"14ms\"", "\"servos\"",          "1e400",
    };
    std::string text = any_example();
    std::vector<std::size_t> places;
    for (std::size_t i = text.find(" = "); i != std::string::npos; i = text.find(" = ", i + 1)) {
        places.push_back(i + 3);
    }
    RC_PRE(!places.empty());
    const std::size_t place = *rc::gen::elementOf(places);
    const std::size_t end = text.find_first_of(",}\n", place);
    text.replace(place, end - place, *rc::gen::elementOf(values));
    expect_an_answer(text);
}

// The parser repeats the line break that it found in the place of "nan".
TEST(AnyBytes, ALineBreakInANumberGetsAnAnswerOfOneLine) {
    expect_an_answer("8=[n\n");
}

TEST(AnyBytes, ADeepNestGetsAnAnswer) {
    const auto configuration = load_configuration("a = " + std::string(100'000, '['), "t.toml");
    EXPECT_FALSE(configuration);
}

TEST(AnyBytes, AThousandWrongLinesGetABoundedAnswer) {
    std::string text;
    for (int i = 0; i < 1000; ++i) {
        text += "= \n";
    }
    const auto configuration = load_configuration(text, "t.toml");
    ASSERT_FALSE(configuration);
    EXPECT_LE(configuration.error().size(), 33U);
}

}  // namespace
}  // namespace tribus::test::any_bytes_test
