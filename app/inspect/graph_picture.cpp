#include "app/inspect/graph_picture.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <string_view>
#include <vector>

#include <fmt/format.h>

namespace tribus {
namespace {

bool is_control(char byte) {
    constexpr unsigned char kDelete = 0x7F;
    const auto value = static_cast<unsigned char>(byte);
    return value < ' ' || value == kDelete;
}

/// `text` with each character replaced as `replace` says; control characters become '?'.
template <class Replace>
std::string escaped(std::string_view text, Replace replace) {
    std::string out;
    for (const char byte : text) {
        const std::string_view other = replace(byte);
        out += is_control(byte) ? std::string_view("?")
               : other.empty()  ? std::string_view(&byte, 1)
                                : other;
    }
    return out;
}

std::string for_xml(std::string_view text) {
    return escaped(text, [](char byte) -> std::string_view {
        switch (byte) {
            case '&':
                return "&amp;";
            case '<':
                return "&lt;";
            case '>':
                return "&gt;";
            case '"':
                return "&quot;";
            default:
                return "";
        }
    });
}

std::string for_dot(std::string_view text) {
    return escaped(text, [](char byte) -> std::string_view {
        return byte == '"' ? "\\\"" : byte == '\\' ? "\\\\" : "";
    });
}

std::string for_mermaid(std::string_view text) {
    return escaped(text, [](char byte) -> std::string_view {
        switch (byte) {
            case '"':
                return "#quot;";
            case '#':
                return "#35;";
            case '<':
                return "#lt;";
            case '>':
                return "#gt;";
            case '`':
                return "#96;";
            default:
                return "";
        }
    });
}

constexpr std::array<std::string_view, kGraphColumns> kColours{"#e3f2e6", "#fff6da", "#e2ecfa",
                                                               "#f1e6f5"};
constexpr std::array<std::string_view, kGraphColumns> kTitles{"inputs", "pipelines", "outputs",
                                                              "lines"};

std::string_view box_colour(const GraphBox& box) {
    return kColours[static_cast<std::size_t>(box.column)];
}

constexpr int kCharacterWidth = 8;  // at 13 px, for any monospace font
constexpr int kLineHeight = 18;
constexpr int kPadding = 10;
constexpr int kGapBetweenBoxes = 22;
constexpr int kGapBetweenColumns = 90;
constexpr int kMargin = 20;
constexpr int kHeading = 26;

int characters(std::string_view text) {
    return static_cast<int>(std::ranges::count_if(
        text, [](char byte) { return (static_cast<unsigned char>(byte) & 0xC0U) != 0x80U; }));
}

struct Place {
    int x = 0;
    int y = 0;
    int width = 0;
    int height = 0;

    int middle() const { return y + height / 2; }
};

struct Layout {
    std::vector<Place> places;
    std::array<int, kGraphColumns> column_x{};
    std::array<bool, kGraphColumns> used{};
    int width = 0;
    int height = 0;
};

int width_of(const GraphBox& box) {
    int longest = characters(box.title);
    for (const std::string& line : box.lines) {
        longest = std::max(longest, characters(line));
    }
    return longest * kCharacterWidth + 2 * kPadding;
}

Layout lay_out(const Graph& graph) {
    Layout layout;
    std::array<int, kGraphColumns> widths{};
    std::array<int, kGraphColumns> heights{};
    for (const GraphBox& box : graph.boxes) {
        const auto column = static_cast<std::size_t>(box.column);
        const int height = (static_cast<int>(box.lines.size()) + 1) * kLineHeight + 2 * kPadding;
        layout.places.push_back({0, heights[column], width_of(box), height});
        widths[column] = std::max(widths[column], width_of(box));
        heights[column] += height + kGapBetweenBoxes;
        layout.used[column] = true;
    }
    int x = kMargin;
    for (std::size_t column = 0; column < kGraphColumns; ++column) {
        layout.column_x[column] = x;
        x += layout.used[column] ? widths[column] + kGapBetweenColumns : 0;
    }
    const int tallest = *std::ranges::max_element(heights);
    for (std::size_t i = 0; i < graph.boxes.size(); ++i) {
        const auto column = static_cast<std::size_t>(graph.boxes[i].column);
        layout.places[i].x = layout.column_x[column];
        layout.places[i].width = widths[column];
        layout.places[i].y += kMargin + kHeading + (tallest - heights[column]) / 2;
    }
    layout.width = std::max(x - kGapBetweenColumns, 0) + kMargin;
    layout.height = tallest + kHeading + 2 * kMargin;
    return layout;
}

/// An arrow whose target is to the left or in the same column goes around.
void draw_arrow(std::string& svg, const GraphArrow& arrow, const Layout& layout) {
    const Place& from = layout.places[arrow.from];
    const Place& to = layout.places[arrow.to];
    const int x1 = from.x + from.width;
    const int x2 = to.x;
    const int bend = std::max(kGapBetweenColumns / 2, std::abs(x2 - x1) / 2);
    svg += fmt::format("<path d=\"M{} {} C{} {} {} {} {} {}\" class=\"a{}\"/>\n", x1, from.middle(),
                       x1 + bend, from.middle(), x2 - bend, to.middle(), x2, to.middle(),
                       arrow.dashed ? " d" : "");
    if (!arrow.label.empty()) {
        svg += fmt::format("<text x=\"{}\" y=\"{}\" class=\"l\">{}</text>\n", x1 + 6,
                           from.middle() - 5, for_xml(arrow.label));
    }
}

void draw_box(std::string& svg, const GraphBox& box, const Place& place) {
    svg +=
        fmt::format("<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" rx=\"6\" fill=\"{}\"/>\n",
                    place.x, place.y, place.width, place.height, box_colour(box));
    int y = place.y + kPadding + kLineHeight - 5;
    svg += fmt::format("<text x=\"{}\" y=\"{}\" class=\"t\">{}</text>\n", place.x + kPadding, y,
                       for_xml(box.title));
    for (const std::string& line : box.lines) {
        y += kLineHeight;
        svg += fmt::format("<text x=\"{}\" y=\"{}\">{}</text>\n", place.x + kPadding, y,
                           for_xml(line));
    }
}

}  // namespace

std::string graph_svg(const Graph& graph) {
    const Layout layout = lay_out(graph);
    std::string svg = fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} "
        "{1}\">\n",
        layout.width, layout.height);
    svg +=
        "<style>text{font:13px monospace;fill:#222}.t{font-weight:bold}.h,.l{fill:#777}"
        "rect{stroke:#8a8a8a}.b{stroke:none}.a{fill:none;stroke:#666;stroke-width:1.5;"
        "marker-end:url(#tip)}.d{stroke-dasharray:5 4}</style>\n"
        "<defs><marker id=\"tip\" viewBox=\"0 0 8 8\" refX=\"8\" refY=\"4\" markerWidth=\"8\" "
        "markerHeight=\"8\" orient=\"auto\"><path d=\"M0 0L8 4L0 8z\" fill=\"#666\"/></marker>"
        "</defs>\n<rect class=\"b\" width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n";
    for (std::size_t column = 0; column < kGraphColumns; ++column) {
        if (layout.used[column]) {
            svg += fmt::format("<text x=\"{}\" y=\"{}\" class=\"h\">{}</text>\n",
                               layout.column_x[column], kMargin + kLineHeight / 2, kTitles[column]);
        }
    }
    for (const GraphArrow& arrow : graph.arrows) {
        draw_arrow(svg, arrow, layout);
    }
    for (std::size_t i = 0; i < graph.boxes.size(); ++i) {
        draw_box(svg, graph.boxes[i], layout.places[i]);
    }
    return svg + "</svg>\n";
}

std::string graph_dot(const Graph& graph) {
    std::string dot =
        "digraph tribus {\n  rankdir=LR;\n  node [shape=box, style=\"rounded,filled\", "
        "fontname=\"monospace\", fontsize=11];\n";
    for (std::size_t i = 0; i < graph.boxes.size(); ++i) {
        std::string label = for_dot(graph.boxes[i].title) + "\\n";
        for (const std::string& line : graph.boxes[i].lines) {
            label += for_dot(line) + "\\l";
        }
        dot += fmt::format("  n{} [label=\"{}\", fillcolor=\"{}\"];\n", i, label,
                           box_colour(graph.boxes[i]));
    }
    for (const GraphArrow& arrow : graph.arrows) {
        dot += fmt::format("  n{} -> n{} [label=\"{}\"{}];\n", arrow.from, arrow.to,
                           for_dot(arrow.label), arrow.dashed ? ", style=dashed" : "");
    }
    return dot + "}\n";
}

std::string graph_mermaid(const Graph& graph) {
    std::string text = "flowchart LR\n";
    for (std::size_t i = 0; i < graph.boxes.size(); ++i) {
        std::string label = "<b>" + for_mermaid(graph.boxes[i].title) + "</b>";
        for (const std::string& line : graph.boxes[i].lines) {
            label += "<br/>" + for_mermaid(line);
        }
        text += fmt::format("  n{}[\"{}\"]\n", i, label);
    }
    for (const GraphArrow& arrow : graph.arrows) {
        text +=
            fmt::format("  n{} {}{} n{}\n", arrow.from, arrow.dashed ? "-.->" : "-->",
                        arrow.label.empty() ? "" : "|" + for_mermaid(arrow.label) + "|", arrow.to);
    }
    return text;
}

}  // namespace tribus
