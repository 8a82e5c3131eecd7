#include "app/client/parse_json.h"

#include <string>

#include <gtest/gtest.h>

namespace tribus::parse_json_test {
namespace {

std::string nested(std::size_t depth, const std::string& inside = "") {
    return std::string(depth, '[') + inside + std::string(depth, ']');
}

TEST(ParseJson, TakesWhatIsNested32DeepAndNothingDeeper) {
    EXPECT_FALSE(parse_json(nested(32)).is_discarded());
    EXPECT_TRUE(parse_json(nested(33)).is_discarded());
    EXPECT_TRUE(parse_json("{\"a\":" + nested(32) + "}").is_discarded());
    EXPECT_TRUE(parse_json(nested(100'000)).is_discarded());
}

TEST(ParseJson, CountsNoBracketsInTexts) {
    const std::string brackets(100, '[');
    EXPECT_EQ(parse_json("\"" + brackets + "\""), brackets);
    EXPECT_EQ(parse_json("[\"\\\"" + brackets + "\"]")[0], "\"" + brackets);
    EXPECT_TRUE(parse_json("[\"\\\\\"," + nested(40) + "]").is_discarded())
        << "the text ended before";
}

TEST(ParseJson, CountsWhatIsOpenNotWhatWas) {
    std::string many = "[0";
    for (int i = 0; i < 1000; ++i) {
        many += ",[{}]";
    }
    EXPECT_EQ(parse_json(many + "]").size(), 1001U);
}

TEST(ParseJson, SaysThatATextIsNoJson) {
    for (const std::string text : {"", "[", "\"", "\"\\", "]]]", "{\"a\":}"}) {
        EXPECT_TRUE(parse_json(text).is_discarded()) << text;
    }
}

}  // namespace
}  // namespace tribus::parse_json_test
