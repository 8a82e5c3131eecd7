#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "app/bench/report.h"
#include "app/bench/requirement.h"

namespace tribus::bench {
namespace {

constexpr double kWidth = 760;
constexpr double kPanelHeight = 300;
constexpr double kLeft = 80;
constexpr double kRight = 180;  // room for the legend
constexpr double kTop = 40;
constexpr double kBottom = 45;
/// The rarest share that is drawn: 10^-4, one frame in ten thousand.
constexpr double kRarest = 4;
constexpr std::array<const char*, 6> kColours{"#0072b2", "#d55e00", "#009e73",
                                              "#cc79a7", "#56b4e9", "#e69f00"};

/// The place of one group of curves.
struct Panel {
    std::string name;
    std::vector<const Curve*> curves{};
    double top = 0;
    double least = 0;  ///< exponents of ten, in nanoseconds
    double most = 1;

    /// 0 % is at the left; equal steps to the right are each ten times rarer.
    double x(double percent) const {
        const double rarity = -std::log10(std::max(1 - percent / 100, std::pow(10, -kRarest)));
        return kLeft + rarity / kRarest * (kWidth - kLeft - kRight);
    }
    double y(double nanoseconds) const {
        const double power = std::log10(std::max(nanoseconds, 1.0));
        const double share = (std::clamp(power, least, most) - least) / (most - least);
        return top + kPanelHeight - kBottom - share * (kPanelHeight - kTop - kBottom);
    }
};

std::string escaped(const std::string& text) {
    std::string safe;
    for (const char letter : text) {
        switch (letter) {
            case '&':
                safe += "&amp;";
                break;
            case '<':
                safe += "&lt;";
                break;
            case '>':
                safe += "&gt;";
                break;
            default:
                safe += letter;
        }
    }
    return safe;
}

std::vector<Panel> panels_of(const Report& report) {
    std::vector<Panel> panels;
    for (const Curve& curve : report.curves) {
        if (curve.times.empty()) {
            continue;
        }
        const auto same = [&](const Panel& panel) { return panel.name == curve.group; };
        auto panel = std::find_if(panels.begin(), panels.end(), same);
        if (panel == panels.end()) {
            panel = panels.insert(panels.end(), Panel{.name = curve.group});
            panel->top = static_cast<double>(panels.size() - 1) * kPanelHeight;
            panel->least = 18;
            panel->most = 0;
        }
        panel->curves.push_back(&curve);
        const auto power = [&](double percent) {
            const Duration time = curve.times.percentile(percent);
            return std::log10(std::max(static_cast<double>(time.count()), 1.0));
        };
        panel->least = std::min(panel->least, std::floor(power(1)));
        panel->most = std::max({panel->most, std::ceil(power(100)), panel->least + 1});
    }
    return panels;
}

void append_text(std::string& svg, double x, double y, const char* anchor,
                 const std::string& text) {
    svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text>\n", x, y,
                       anchor, escaped(text));
}

void append_line(std::string& svg, double x1, double y1, double x2, double y2) {
    svg += fmt::format(
        "<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"#ccc\"/>\n", x1, y1,
        x2, y2);
}

void append_axes(std::string& svg, const Panel& panel) {
    const double bottom = panel.top + kPanelHeight - kBottom;
    svg += fmt::format("<text x=\"{}\" y=\"{}\" font-size=\"15\" font-weight=\"bold\">{}</text>\n",
                       kLeft, panel.top + kTop - 15, escaped(panel.name));
    constexpr std::array<double, 7> kPercents{0, 50, 90, 99, 99.9, 99.99, 100};
    for (const double percent : kPercents) {
        if (percent < 100) {
            append_line(svg, panel.x(percent), panel.top + kTop, panel.x(percent), bottom);
            append_text(svg, panel.x(percent), bottom + 18, "middle", fmt::format("p{}", percent));
        }
    }
    const int last_power = static_cast<int>(panel.most);
    for (int power = static_cast<int>(panel.least); power <= last_power; ++power) {
        const double nanoseconds = std::pow(10, power);
        append_line(svg, kLeft, panel.y(nanoseconds), kWidth - kRight, panel.y(nanoseconds));
        append_text(svg, kLeft - 8, panel.y(nanoseconds) + 4, "end",
                    short_time(Duration(static_cast<std::int64_t>(nanoseconds))));
    }
}

void append_curve(std::string& svg, const Panel& panel, std::size_t index) {
    const Curve& curve = *panel.curves[index];
    const char* colour = kColours[index % kColours.size()];
    constexpr int kSteps = 200;
    std::string points;
    for (int step = 0; step <= kSteps; ++step) {
        const double percent = 100 * (1 - std::pow(10, -kRarest * step / kSteps));
        const auto time = static_cast<double>(curve.times.percentile(percent).count());
        points += fmt::format("{:.1f},{:.1f} ", panel.x(percent), panel.y(time));
    }
    svg += fmt::format("<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"2\"/>\n",
                       points, colour);
    const double y = panel.top + kTop + 20 * static_cast<double>(index) + 10;
    const double x = kWidth - kRight + 15;
    svg += fmt::format(
        "<line x1=\"{0}\" y1=\"{1}\" x2=\"{2}\" y2=\"{1}\" stroke=\"{3}\" stroke-width=\"3\"/>\n",
        x, y, x + 20, colour);
    append_text(svg, x + 26, y + 4, "start", curve.name);
}

}  // namespace

std::string report_svg(const Report& report) {
    const std::vector<Panel> panels = panels_of(report);
    const double height = std::max(kTop, kPanelHeight * static_cast<double>(panels.size()));
    std::string svg = fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" "
        "height=\"{1}\" font-family=\"sans-serif\" font-size=\"12\">\n"
        "<rect width=\"{0}\" height=\"{1}\" fill=\"white\"/>\n",
        kWidth, height);
    for (const Panel& panel : panels) {
        append_axes(svg, panel);
        for (std::size_t i = 0; i < panel.curves.size(); ++i) {
            append_curve(svg, panel, i);
        }
    }
    return svg + "</svg>\n";
}

}  // namespace tribus::bench
