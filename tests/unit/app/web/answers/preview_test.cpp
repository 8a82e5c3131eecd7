#include <string>
#include <utility>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/web/answers/preview.h"
#include "config/load.h"

namespace tribus::web::preview_test {
namespace {

using nlohmann::json;

Configuration configured(const std::string& map) {
    auto configuration = load_configuration(R"(
[input.a]
protocol = "ibus"
device = "/dev/ttyA"
[input.b]
protocol = "ibus"
device = "/dev/ttyB"
[output.servos]
protocol = "sbus"
device = "/dev/ttyC"
[pipeline.main]
from = ["a", "b"]
to = "servos"
)" + map,
                                            "boat.toml");
    EXPECT_TRUE(configuration) << configuration.error().front().text;
    return std::move(*configuration);
}

/// Input a is lost; b has 1200 us, nothing, 1988.5 us.
const json kStatus = json::parse(R"({"inputs":[
    {"name":"a","state":"failsafe","channels":[1000,1000,1000]},
    {"name":"b","state":"good","channels":[1200,null,1988.5]}]})");

TEST(ChannelsChangedByADraft, AreShownAsTheyAreAndAsTheyWouldBe) {
    const auto changed = channels_changed_by(
        configured(""),
        configured("[pipeline.main.channels]\n1 = { from = 1, reverse = true }\n2 = 1\n"), kStatus);
    EXPECT_EQ(changed.dump(),
              R"([{"output":"servos","channels":[{"channel":1,"now_us":1200,"then_us":1800},)"
              R"({"channel":2,"now_us":null,"then_us":1200}]}])");
}

TEST(ChannelsChangedByADraft, TakeTheMapOfAnInputIntoAccount) {
    const auto changed = channels_changed_by(
        configured(""), configured("[input.b.map]\n3 = { from = 3, max = 1900 }\n"), kStatus);
    EXPECT_EQ(changed.dump(),
              R"([{"output":"servos","channels":[{"channel":3,"now_us":1989,"then_us":1900}]}])");
}

TEST(ChannelsChangedByADraft, AreNoneWithoutAnInputThatIsGood) {
    const auto draft = configured("[pipeline.main.channels]\n1 = { from = 1, reverse = true }\n");
    for (const json& status :
         {json(), json::object(), json::parse(R"({"inputs":[1,{"name":7}]})")}) {
        EXPECT_EQ(channels_changed_by(configured(""), draft, status).dump(), "[]") << status;
    }
    EXPECT_EQ(channels_changed_by(draft, draft, kStatus).dump(), "[]");
}

}  // namespace
}  // namespace tribus::web::preview_test
