#include <chrono>
#include <sstream>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/bench/measurements.h"

namespace tribus::bench::bench_report_test {
namespace {

using namespace std::chrono_literals;

Report some_report() {
    Report report;
    report.missing = {"the memory is not locked"};
    report.add("latency", "p50", 42us, 40us, 40us, "a bare relay");
    report.add("latency", "p99", 2520us, 180us, 180us, "a bare relay");
    report.measurements.push_back(
        {.group = "latency", .what = "frames lost or torn", .unit = "frames", .reading = "of 121"});
    report.add("cpu", "a frame", 999'600ns, 850ns, 850ns, "a bare relay");
    return report;
}

std::string broken_by(const Report& report, std::string_view requirement) {
    Report judged = report;
    judged.judge(*parse_requirement(requirement));
    return judged.broken.empty() ? "" : judged.broken.front();
}

TEST(Requirement, NamesAPercentileAndATime) {
    const auto requirement = parse_requirement("p99=200us");
    ASSERT_TRUE(requirement) << requirement.error();
    EXPECT_EQ(requirement->what, "p99");
    EXPECT_EQ(requirement->most, 200us);
    EXPECT_FALSE(requirement->added);
}

TEST(Requirement, MayBeOfWhatIsAdded) {
    const auto requirement = parse_requirement("added-p50=1.5ms");
    ASSERT_TRUE(requirement) << requirement.error();
    EXPECT_EQ(requirement->what, "p50");
    EXPECT_EQ(requirement->most, 1500us);
    EXPECT_TRUE(requirement->added);
}

class WrongRequirement : public testing::TestWithParam<const char*> {};

TEST_P(WrongRequirement, IsRefusedWithWhatIsAllowed) {
    const auto requirement = parse_requirement(GetParam());
    ASSERT_FALSE(requirement);
    EXPECT_EQ(requirement.error().rfind("--require " + std::string(GetParam()), 0), 0U);
    EXPECT_NE(requirement.error().find("p50, p90 or p99"), std::string::npos);
    EXPECT_NE(requirement.error().find("p99=200us"), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(Texts, WrongRequirement,
                         testing::Values("", "p99", "p99=", "p99=200", "p99=-1us", "p95=200us",
                                         "added-=3us", "p99 = 200us", "=200us", "p99=fast"));

TEST(Requirement, HoldsUpToItsTime) {
    EXPECT_EQ(broken_by(some_report(), "p50=42us"), "");
    EXPECT_EQ(broken_by(some_report(), "p50=41us"),
              "p50=41us does not hold: the latency's p50 was 42us");
}

TEST(Requirement, LeavesOutTheBareRelayInWhatIsAdded) {
    EXPECT_EQ(broken_by(some_report(), "added-p50=2us"), "");
    EXPECT_EQ(broken_by(some_report(), "added-p50=1us"),
              "added-p50=1us does not hold: the added latency's p50 was 2us");
}

TEST(ReportText, HasARowForEachMeasurementInEightyColumns) {
    Report report = some_report();
    report.broken = {"p99=1us does not hold: the latency's p99 was 2.52ms"};
    EXPECT_EQ(report_text(report),
              "not permitted here: the memory is not locked\n"
              "what                   figure    beside  ratio  reading\n"
              "\n"
              "Latency, from the write of a frame to the read of its last byte\n"
              "p50                      42us      40us   1.05  as good as a bare relay\n"
              "p99                    2.52ms     180us  14.00  worse than a bare relay\n"
              "frames lost or torn         0                   of 121\n"
              "\n"
              "Processor time of the thread that carries a frame each 7 ms\n"
              "a frame                   1ms    0.85us 1176.00  worse than a bare relay\n"
              "p99=1us does not hold: the latency's p99 was 2.52ms\n");
}

std::string reading_of(Duration figure, Duration anchor, Duration anchor_again) {
    Report report;
    report.add("lateness", "p99", figure, anchor, anchor_again, "a bare timer");
    EXPECT_LE(report_text(report).substr(report_text(report).rfind("p99")).size(), 81U);
    return report.measurements.front().reading;
}

TEST(Reading, IsAsGoodWithinATenthAndTheNoise) {
    EXPECT_EQ(reading_of(108us, 100us, 100us), "as good as a bare timer");
    EXPECT_EQ(reading_of(120us, 100us, 110us), "as good as a bare timer");
    EXPECT_EQ(reading_of(112us, 100us, 90us), "nearly as good as a bare timer");
}

TEST(Reading, TellsBetterNearlyAndWorse) {
    EXPECT_EQ(reading_of(50us, 100us, 100us), "better than a bare timer");
    EXPECT_EQ(reading_of(140us, 100us, 100us), "nearly as good as a bare timer");
    EXPECT_EQ(reading_of(300us, 100us, 100us), "worse than a bare timer");
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
    EXPECT_EQ(json.at("measurements").at(2).count("ratio"), 0U);
    EXPECT_EQ(json.at("missing").at(0), "the memory is not locked");
}

}  // namespace
}  // namespace tribus::bench::bench_report_test
