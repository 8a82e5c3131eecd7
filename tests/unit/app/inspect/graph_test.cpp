#include <algorithm>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "app/inspect/graph_model.h"
#include "app/inspect/graph_picture.h"
#include "config/keys/keys.h"
#include "config/load.h"
#include "core/channel_frame.h"
#include "tests/unit/config/main_job.h"

namespace tribus::test::graph_test {
namespace {

constexpr const char* kConfig = R"([input.main]
protocol = "ibus"
device   = "/dev/ttyAMA5"
[input.backup]
protocol = "sbus"
device   = "/dev/ttyAMA4"
[output.servos]
protocol = "sbus"
device   = "/dev/ttyAMA3"
[pipeline.car]
from = ["main", "backup"]
to   = "servos"
[pipeline.car.channels]
2 = { from = 1, reverse = true, trim = 12 }
5 = { mix = { 1 = 0.5, 2 = -0.5 } }
[gpio.lamp]
line = "GPIO17"
role = "link"
)";

Graph graph() {
    return graph_of(*load_configuration(kConfig, "car.toml"));
}

TEST(Graph, HasABoxForEachPart) {
    const Graph drawn = graph();
    ASSERT_EQ(drawn.boxes.size(), 5U);
    EXPECT_EQ(drawn.boxes[0].title, "main");
    EXPECT_EQ(drawn.boxes[0].lines[0], "ibus from /dev/ttyAMA5");
    EXPECT_EQ(drawn.boxes[2].title, "car");
    EXPECT_EQ(drawn.boxes[3].column, GraphColumn::outputs);
    EXPECT_EQ(drawn.boxes[4].lines[0], "GPIO17 link");
}

TEST(Graph, TellsHowChannelsAreMade) {
    const Graph drawn = graph();
    EXPECT_EQ(drawn.boxes[2].lines,
              (std::vector<std::string>{"mode priority", "2 = channel 1, reverse, trim 12 us",
                                        "5 = mix { 1 = 0.5, 2 = -0.5 }"}));
}

TEST(Graph, TellsWhatHappensAtALoss) {
    const std::vector<std::string> lines = graph().boxes[3].lines;
    EXPECT_EQ(std::vector(lines.end() - 2, lines.end()),
              (std::vector<std::string>{"lost: 300 ms hold, then preset",
                                        "preset { 3 = 988, other = 1500 }"}));
}

bool is_source(const Key& key) {
    return std::ranges::find(channel_source_names(), key.name()) != channel_source_names().end();
}

/// An entry of a map that has the key, with the value that its row gives as an example.
std::string entry_with(const Key& key) {
    return fmt::format("7 = {{ {}{} = {} }}", is_source(key) ? "" : "from = 1, ", key.name(),
                       key.setting.example);
}

/// What a picture must say of a key with the value of its example.
std::string words_of(const Key& key) {
    std::string value(key.setting.example);
    std::erase(value, '"');
    return value == "true" ? std::string(key.name()) : fmt::format("{} {}", key.name(), value);
}

std::string line_of_entry_with(const Key& key) {
    return key.name() == "from" ? fmt::format("7 = channel {}", key.setting.example)
           : is_source(key)     ? "7 = " + words_of(key)
                                : "7 = channel 1, " + words_of(key);
}

void expect_in_every_picture(const std::string& config, const std::string& text) {
    const Graph drawn = graph_of(loaded(config));
    for (const std::string& picture : {graph_svg(drawn), graph_dot(drawn), graph_mermaid(drawn)}) {
        EXPECT_NE(picture.find(text), std::string::npos) << text << "\n" << picture;
    }
}

TEST(Graph, DrawsEveryKeyOfAChannelOfAPipeline) {
    for (const Key& key : channel_keys()) {
        expect_in_every_picture(
            main_job_with(10, "[pipeline.main.channels]\n8 = { line = \"record\" }\n" +
                                  entry_with(key) +
                                  "\n[gpio.record]\nline = \"GPIO4\"\nrole = \"button\"\n"),
            line_of_entry_with(key));
    }
}

TEST(Graph, DrawsEveryKeyOfAChannelOfAnInput) {
    for (const Key& key : channel_keys()) {
        if (key.name() != "line") {  // only in a pipeline
            expect_in_every_picture(
                main_job_with(10, "[input.receiver.map]\n" + entry_with(key) + "\n"),
                line_of_entry_with(key));
        }
    }
}

TEST(Graph, DrawsAllStepsOfAChannelInTheOrderOfTheManual) {
    expect_in_every_picture(
        main_job_with(10,
                      "[pipeline.main.channels]\n7 = { from = 1, max = 1900, min = 1100, slew = "
                      "\"2000us/s\", deadband = 4, expo = 0.3, trim = 12.5, reverse = true }\n"),
        "7 = channel 1, reverse, trim 12.5 us, expo 0.3, deadband 4 us, slew 2000us/s, min 1100 "
        "us, max 1900 us");
}

TEST(Graph, DrawsAMapOfEveryChannel) {
    std::string map = "[input.receiver.map]\n";
    for (std::size_t channel = 1; channel <= kChannelCount; ++channel) {
        map += fmt::format("{} = 1\n", channel);
    }
    for (std::size_t channel = 1; channel <= kChannelCount; ++channel) {
        expect_in_every_picture(main_job_with(10, map), fmt::format("{} = channel 1", channel));
    }
}

TEST(Graph, DrawsEveryKeyOfFailsafeThatIsNotAtItsDefault) {
    for (const Key& key : output_failsafe_keys()) {
        if (key.name() != "hold" && key.name() != "action") {  // in words: "lost: ..."
            expect_in_every_picture(main_job_with(10, fmt::format("[pipeline.main.failsafe]\n"
                                                                  "{} = {}\n",
                                                                  key.name(), key.setting.example)),
                                    words_of(key));
        }
    }
}

TEST(Graph, DrawsHowSeveralInputsAreSelected) {
    const Graph drawn = graph_of(loaded(R"([input.main]
protocol = "ibus"
device = "/dev/ttyA"
[input.backup]
protocol = "ibus"
device = "/dev/ttyB"
[output.servos]
protocol = "sbus"
device = "/dev/ttyC"
[pipeline.car]
from = ["main", "backup"]
to = "servos"
mode = "sticky"
handover = { input = "main", channel = 8 }
changeover = "2000us/s"
)"));
    EXPECT_EQ(drawn.boxes[2].lines,
              (std::vector<std::string>{"mode sticky", "handover { input = main, channel = 8 }",
                                        "changeover 2000us/s"}));
}

TEST(Graph, NumbersInputsInTheirOrder) {
    const Graph drawn = graph();
    ASSERT_EQ(drawn.arrows.size(), 4U);
    EXPECT_EQ(drawn.arrows[0].from, 0U);
    EXPECT_EQ(drawn.arrows[0].to, 2U);
    EXPECT_EQ(drawn.arrows[0].label, "1");
    EXPECT_EQ(drawn.arrows[1].label, "2");
    EXPECT_EQ(drawn.arrows[2].to, 3U);
    EXPECT_TRUE(drawn.arrows[3].dashed);
}

TEST(GraphPicture, IsTheSameForTheSameGraph) {
    EXPECT_EQ(graph_svg(graph()), graph_svg(graph()));
}

const Graph kHostile{
    {{GraphColumn::sources, R"(<"a&b">\)", {"#`\x1b"}}, {GraphColumn::outputs, "out", {}}},
    {{0, 1, "<1>", false}}};

TEST(GraphPicture, EscapesForXml) {
    const std::string svg = graph_svg(kHostile);
    EXPECT_NE(svg.find("&lt;&quot;a&amp;b&quot;&gt;\\"), std::string::npos) << svg;
    EXPECT_NE(svg.find(">&lt;1&gt;<"), std::string::npos) << svg;
    EXPECT_EQ(svg.find('\x1b'), std::string::npos);
}

TEST(GraphPicture, EscapesForDot) {
    EXPECT_NE(graph_dot(kHostile).find(R"(n0 [label="<\"a&b\">\\\n#`?\l")"), std::string::npos)
        << graph_dot(kHostile);
}

TEST(GraphPicture, EscapesForMermaid) {
    EXPECT_EQ(graph_mermaid(kHostile),
              "flowchart LR\n  n0[\"<b>#lt;#quot;a&b#quot;#gt;\\</b><br/>#35;#96;?\"]\n"
              "  n1[\"<b>out</b>\"]\n  n0 -->|#lt;1#gt;| n1\n");
}

TEST(GraphPicture, IsAPictureOfNothingToo) {
    EXPECT_TRUE(graph_svg({}).starts_with("<svg"));
    EXPECT_EQ(graph_mermaid({}), "flowchart LR\n");
}

}  // namespace
}  // namespace tribus::test::graph_test
