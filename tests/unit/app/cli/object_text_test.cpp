#include "app/cli/object_text.h"

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace tribus::test::object_text_test {
namespace {

using Json = nlohmann::ordered_json;

TEST(ObjectText, IsWhatTheWholeTreeWouldBe) {
    const std::vector<Json> inputs{{{"name", "receiver"}, {"frames", 12}}, {{"name", "spare"}}};
    ObjectText text;
    text.add("version", "1.0");
    text.add_list("inputs", inputs.size(), [&](std::size_t i) { return inputs[i]; });
    text.add("trial", nullptr);
    const Json tree{{"version", "1.0"}, {"inputs", inputs}, {"trial", nullptr}};
    EXPECT_EQ(std::move(text).end(), tree.dump());
}

TEST(ObjectText, BeginsWithAListAsWell) {
    ObjectText text;
    text.add_list("ports", 1, [](std::size_t i) { return i; });
    text.add("late", true);
    EXPECT_EQ(std::move(text).end(), R"({"ports":[0],"late":true})");
}

TEST(ObjectText, WritesAListOfNothing) {
    ObjectText text;
    text.add_list("nodes", 0, [](std::size_t i) { return i; });
    EXPECT_EQ(std::move(text).end(), R"({"nodes":[]})");
}

TEST(ObjectText, ReplacesBytesThatNoTextHas) {
    ObjectText text;
    text.add("device", "/dev/tty\xFF");
    EXPECT_EQ(std::move(text).end(), "{\"device\":\"/dev/tty\xEF\xBF\xBD\"}");
}

TEST(ObjectText, IsAnObjectStillWithoutAMember) {
    EXPECT_EQ(ObjectText().end(), "{}");
}

}  // namespace
}  // namespace tribus::test::object_text_test
