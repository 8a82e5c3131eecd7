#include "app/bench/report.h"

#include <chrono>
#include <regex>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace tribus::bench::bench_report_test {
namespace {

using namespace std::chrono_literals;

Report some_report() {
    Report report;
    report.missing = {"the memory is not locked"};
    report.add("latency", "p50", 42us, 40us, "as good as a bare relay");
    report.curves.push_back(
        {"latency", "a < b & c", Distribution(std::vector<Duration>{1us, 30us, 2ms})});
    report.curves.push_back({"latency", "nothing arrived", Distribution()});
    report.curves.push_back({"age", "follow", Distribution(std::vector<Duration>{0ns, 5us})});
    return report;
}

/// Returns whether every element is closed in order and every special character is escaped.
bool well_formed(const std::string& xml) {
    static const std::regex kTag(R"(<(/?)([a-z]+)((?: [a-zA-Z0-9-]+="[^"<]*")*)(/?)>)");
    std::vector<std::string> open;
    std::size_t end = 0;
    for (std::sregex_iterator tag(xml.begin(), xml.end(), kTag), none; tag != none; ++tag) {
        const auto at = static_cast<std::size_t>(tag->position());
        const std::string text = xml.substr(end, at - end);
        if (text.find('<') != std::string::npos ||
            std::regex_search(text, std::regex("&(?!(amp|lt|gt);)"))) {
            return false;
        }
        end = at + static_cast<std::size_t>(tag->length());
        if (tag->str(1) == "/") {
            if (open.empty() || open.back() != tag->str(2)) {
                return false;
            }
            open.pop_back();
        } else if (tag->str(4).empty()) {
            open.push_back(tag->str(2));
        }
    }
    return open.empty() && xml.find('<', end) == std::string::npos;
}

std::size_t count_of(const std::string& part, const std::string& text) {
    std::size_t count = 0;
    for (std::size_t at = text.find(part); at != std::string::npos;
         at = text.find(part, at + part.size())) {
        ++count;
    }
    return count;
}

TEST(ReportPlot, IsWellFormedWhateverTheNames) {
    EXPECT_TRUE(well_formed(report_svg(some_report()))) << report_svg(some_report());
    EXPECT_TRUE(well_formed(report_svg(Report())));
}

TEST(ReportPlot, DrawsEachCurveThatHasTimes) {
    const std::string svg = report_svg(some_report());
    EXPECT_EQ(count_of("<polyline", svg), 2U);
    EXPECT_NE(svg.find("a &lt; b &amp; c"), std::string::npos);
    EXPECT_NE(svg.find(">age<"), std::string::npos) << "the name of a panel";
    EXPECT_EQ(svg.find("nothing arrived"), std::string::npos);
}

TEST(ReportPlot, StaysWithinItsFrame) {
    const std::string svg = report_svg(some_report());
    EXPECT_EQ(svg.find("nan"), std::string::npos);
    EXPECT_EQ(svg.find("inf"), std::string::npos);
    EXPECT_EQ(svg.find("=\"-"), std::string::npos) << "a negative position";
}

TEST(ReportText, SaysWhatWasNotPermittedAndWhatIsBroken) {
    Report report = some_report();
    report.broken = {"p99=1us does not hold: the latency's p99 was 2us"};
    const std::string text = report_text(report, 80);
    EXPECT_EQ(text.rfind("not permitted here: the memory is not locked\n", 0), 0U) << text;
    EXPECT_NE(text.find("p99=1us does not hold"), std::string::npos);
    EXPECT_NE(text.find("as good as a bare relay"), std::string::npos);
}

TEST(ReportJson, HasEveryFigureWithItsAnchorAndRatio) {
    const auto json = nlohmann::json::parse(report_json(some_report()));
    const auto& latency = json.at("measurements").at(0);
    EXPECT_EQ(latency.at("group"), "latency");
    EXPECT_EQ(latency.at("what"), "p50");
    EXPECT_EQ(latency.at("unit"), "ns");
    EXPECT_EQ(latency.at("figure"), 42000);
    EXPECT_EQ(latency.at("anchor"), 40000);
    EXPECT_DOUBLE_EQ(latency.at("ratio"), 1.05);
    EXPECT_EQ(json.at("missing").at(0), "the memory is not locked");
}

}  // namespace
}  // namespace tribus::bench::bench_report_test
