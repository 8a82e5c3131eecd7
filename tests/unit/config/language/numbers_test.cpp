#include "config/language/numbers.h"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace tribus::test::numbers_test {
namespace {

/// `NUMBER: RULE`; empty if there is no repair.
std::string repair(std::string_view word) {
    const auto repaired = repaired_number(word);
    return repaired ? repaired->number + ": " + std::string(repaired->rule) : "";
}

TEST(RepairedNumber, HasNoZerosInFront) {
    const std::string rule = ": a number does not begin with 0";
    EXPECT_EQ(repair("0115200"), "115200" + rule);
    EXPECT_EQ(repair("05"), "5" + rule);
    EXPECT_EQ(repair("-05"), "-5" + rule);
    EXPECT_EQ(repair("+007"), "+7" + rule);
    EXPECT_EQ(repair("000"), "0" + rule);
    EXPECT_EQ(repair("0_1"), "1" + rule);
    EXPECT_EQ(repair("01_000"), "1_000" + rule);
    EXPECT_EQ(repair("00.5"), "0.5" + rule);
    EXPECT_EQ(repair("-007.50"), "-7.50" + rule);
}

TEST(RepairedNumber, HasDigitsOnBothSidesOfItsPoint) {
    const std::string rule = ": a decimal point has digits on both sides";
    EXPECT_EQ(repair(".3"), "0.3" + rule);
    EXPECT_EQ(repair("-.30"), "-0.30" + rule);
    EXPECT_EQ(repair("5."), "5.0" + rule);
    EXPECT_EQ(repair("+15."), "+15.0" + rule);
    EXPECT_EQ(repair("05."), "5.0" + rule);
    EXPECT_EQ(repair("00."), "0.0" + rule);
}

TEST(RepairedNumber, HasASmallLetterInItsPrefix) {
    const std::string rule = ": 0x, 0o and 0b have small letters";
    EXPECT_EQ(repair("0X3F"), "0x3F" + rule);
    EXPECT_EQ(repair("0O17"), "0o17" + rule);
    EXPECT_EQ(repair("0B1"), "0b1" + rule);
}

TEST(RepairedNumber, IsNoneForARightNumberAndForWords) {
    for (const std::string_view word :
         {"",    "0",   "7",    "10",   "-5",  "0.5",   "-0.5", "10.0", "1_000", "0x3f", "-0X3F",
          "0X",  "0Y3", "1X3",  "X03",  "-",   "+",     ".",    "-.",   "1.2.3", ".1.2", "a",
          "a.1", "1.a", "01a",  "0a",   "a0",  "--05",  "0 5",  "ibus", "0.a",   "05.a", ".a",
          "a.",  "1-",  "0x.5", "0.5.", "1e5", "01e05", "_",    "5us"}) {
        EXPECT_EQ(repair(word), "") << word;
    }
}

TEST(RepairedNumber, IsZeroWhereNothingIsLeft) {
    EXPECT_EQ(repair("0_"), "0: a number does not begin with 0");
}

Value text(std::string content) {
    return {.where = {4, 7}, .content = std::move(content)};
}

template <class T>
std::optional<T> inside(const std::string& content) {
    const auto value = value_in_text(text(content));
    return value && value->as<T>() != nullptr ? std::optional(*value->as<T>()) : std::nullopt;
}

TEST(ValueInText, IsTheNumberOrTruthThatItConsistsOf) {
    EXPECT_EQ(inside<std::int64_t>("5"), 5);
    EXPECT_EQ(inside<std::int64_t>(" -5 "), -5);
    EXPECT_EQ(inside<std::int64_t>("0x10"), 16);
    EXPECT_EQ(inside<double>("0.5"), 0.5);
    EXPECT_EQ(inside<bool>("true"), true);
    EXPECT_EQ(inside<bool>("false"), false);
}

TEST(ValueInText, IsTheNumberThatIsMeant) {
    EXPECT_EQ(inside<std::int64_t>("0115"), 115);
    EXPECT_EQ(inside<double>(".5"), 0.5);
}

TEST(ValueInText, StandsWhereTheTextStands) {
    const auto value = value_in_text(text("5"));
    ASSERT_TRUE(value);
    EXPECT_EQ(value->where.line, 4U);
    EXPECT_EQ(value->where.column, 7U);
}

TEST(ValueInText, IsNoneInOtherTexts) {
    for (const std::string content : {"", "ibus", "\"5\"", "'5'", "5\n", "5 # five", "[1]",
                                      "{ a = 1 }", "1979-05-27", "5, b = 1", "5ms", "5\nb = 1"}) {
        EXPECT_FALSE(value_in_text(text(content))) << content;
    }
    EXPECT_FALSE(value_in_text({.where = {1, 1}, .content = std::int64_t{5}}));
}

TEST(BareText, IsTheValueAsItShouldStandInTheFile) {
    EXPECT_EQ(bare_text(text("05")), "5");
    EXPECT_EQ(bare_text(text("true")), "true");
}

Value list(const std::vector<std::string>& texts) {
    List items;
    for (const std::string& content : texts) {
        items.items.push_back(text(content));
    }
    return {.where = {1, 1}, .content = std::move(items)};
}

TEST(HintToLeaveQuotesOut, IsGivenForATextOrAListWithANumber) {
    EXPECT_EQ(without_quotes_hint(text("5")), ", without quotes");
    EXPECT_EQ(without_quotes_hint(list({"a", "5"})), ", without quotes");
    EXPECT_EQ(without_quotes_hint(text("a")), "");
    EXPECT_EQ(without_quotes_hint(list({"a", "b"})), "");
    EXPECT_EQ(without_quotes_hint(list({})), "");
    EXPECT_EQ(without_quotes_hint({.where = {1, 1}, .content = std::int64_t{5}}), "");
}

}  // namespace
}  // namespace tribus::test::numbers_test
