#include "app/status/histograms.h"

#include <chrono>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace tribus::histograms_test {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;

TEST(Histograms, HaveACountForEachBucketUpToTheLastThatIsUsed) {
    HistogramReading minute;
    minute.counts[histogram_bucket(1500ns)] = 3;
    minute.counts[histogram_bucket(0ns)] = 2;
    minute.worst = 1537ns;
    const HistogramsReport report{
        .now = Instant(7s),
        .inputs = {{.name = "receiver",
                    .histograms = {{.what = "frame_age", .last_minute = {}, .since_start = {}}}}},
        .outputs = {
            {.name = "servos",
             .histograms = {{.what = "latency", .last_minute = minute, .since_start = minute}}}}};
    const std::string text = histograms_json(report);
    EXPECT_EQ(text.find('\n'), std::string::npos);
    const json told = json::parse(text);
    EXPECT_EQ(told["type"], "histograms");
    EXPECT_EQ(told["version"], 1);
    EXPECT_EQ(told["t_us"], 7'000'000);
    ASSERT_EQ(told["starts_us"].size(), kHistogramBuckets);
    EXPECT_EQ(told["starts_us"][1], 0.256);
    EXPECT_EQ(told["starts_us"][histogram_bucket(1500ns)], 1.28);
    EXPECT_EQ(told["outputs"][0]["name"], "servos");
    const json latency = told["outputs"][0]["latency"]["last_minute"];
    EXPECT_EQ(latency["counts"], json::parse("[2,0,0,0,0,3]"));
    EXPECT_EQ(latency["max_us"], 1.537);
    EXPECT_EQ(told["outputs"][0]["latency"]["since_start"], latency);
    EXPECT_EQ(told["inputs"][0]["frame_age"]["last_minute"]["counts"], json::array());
    EXPECT_FALSE(told["inputs"][0].contains("latency"));
}

}  // namespace
}  // namespace tribus::histograms_test
