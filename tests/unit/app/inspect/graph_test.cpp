#include <string>

#include <gtest/gtest.h>

#include "app/inspect/graph_model.h"
#include "app/inspect/graph_picture.h"
#include "config/load.h"

namespace tribus::graph_test {
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
              (std::vector<std::string>{"mode priority", "2 = 1, reversed, trim +12",
                                        "5 = 0.5 x 1 + -0.5 x 2"}));
}

TEST(Graph, TellsWhatHappensAtALoss) {
    EXPECT_EQ(graph().boxes[3].lines.back(), "lost: 300 ms hold, then preset");
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

TEST(GraphPicture, OfTheSameGraphIsTheSame) {
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

TEST(GraphPicture, OfNothingIsAPicture) {
    EXPECT_TRUE(graph_svg({}).starts_with("<svg"));
    EXPECT_EQ(graph_mermaid({}), "flowchart LR\n");
}

}  // namespace
}  // namespace tribus::graph_test
