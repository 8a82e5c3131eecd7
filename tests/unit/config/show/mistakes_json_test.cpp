#include "config/show/mistakes_json.h"

#include <vector>

#include <gtest/gtest.h>

namespace tribus::test::mistakes_json_test {
namespace {

TEST(MistakesJson, HasThePlaceAndTheSentenceOfEachMistake) {
    const std::vector<Mistake> mistakes{{"a.toml", {3, 10}, "\"x\" is 1; allowed: 2"},
                                        {"b.toml", {}, "cannot be read"}};
    EXPECT_EQ(mistakes_document(mistakes), R"({
  "mistakes": [
    {
      "file": "a.toml",
      "line": 3,
      "column": 10,
      "text": "\"x\" is 1; allowed: 2"
    },
    {
      "file": "b.toml",
      "text": "cannot be read"
    }
  ]
}
)");
}

TEST(MistakesJson, ReplacesBytesOfFileNamesThatAreNotUtf8) {
    const std::vector<Mistake> mistakes{{"\xE4.toml", {1, 1}, "wrong"}};
    EXPECT_NE(mistakes_document(mistakes).find("\"\uFFFD.toml\""), std::string::npos);
}

}  // namespace
}  // namespace tribus::test::mistakes_json_test
