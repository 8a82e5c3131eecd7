#include <string>

#include <gtest/gtest.h>

#include "app/web/answers/metrics.h"

namespace tribus::web::metrics_of_all_test {
namespace {

/// Text format 0.0.4: "All lines for a given metric must be provided as one single group".
TEST(MetricsOfAll, KeepsTheSamplesOfAFamilyTogether) {
    const std::string boat =
        "# HELP tribus_a One.\n# TYPE tribus_a gauge\ntribus_a{daemon=\"boat\"} 1\n"
        "# HELP tribus_b Two.\n# TYPE tribus_b gauge\ntribus_b{daemon=\"boat\"} 2\n";
    const std::string car =
        "# HELP tribus_b Two.\n# TYPE tribus_b gauge\ntribus_b{daemon=\"car\"} 3\n"
        "# HELP tribus_c Three.\n# TYPE tribus_c gauge\ntribus_c{daemon=\"car\"} 4\n";
    const std::string all = metrics_of_all({{"boat", boat}, {"car", car}});
    const std::string rest = all.substr(all.find("# HELP tribus_a"));
    EXPECT_EQ(rest,
              "# HELP tribus_a One.\n# TYPE tribus_a gauge\ntribus_a{daemon=\"boat\"} 1\n"
              "# HELP tribus_b Two.\n# TYPE tribus_b gauge\ntribus_b{daemon=\"boat\"} 2\n"
              "tribus_b{daemon=\"car\"} 3\n"
              "# HELP tribus_c Three.\n# TYPE tribus_c gauge\ntribus_c{daemon=\"car\"} 4\n");
}

TEST(MetricsOfAll, SaysWhichDaemonsAnswered) {
    const std::string all = metrics_of_all({{"boat", ""}, {"car", std::nullopt}});
    EXPECT_NE(all.find("\ntribus_daemon_answers{daemon=\"boat\"} 1\n"), std::string::npos) << all;
    EXPECT_NE(all.find("\ntribus_daemon_answers{daemon=\"car\"} 0\n"), std::string::npos) << all;
}

TEST(MetricsOfAll, NamesADaemonWhoseNameIsNoUtf8) {
    const std::string all =
        metrics_of_all({{"b\xE4r", ""}, {"bär", ""}, {"\xC3", ""}, {"\\\"\n", ""}});
    for (const std::string label : {R"("b\\xE4r")", R"("bär")", R"("\\xC3")", R"("\\\"\n")"}) {
        EXPECT_NE(all.find("{daemon=" + label + "} 1\n"), std::string::npos) << label << all;
    }
}

TEST(MetricsOfAll, TakesATextThatBreaksOff) {
    for (const std::string text : {"# HELP tribus_a One.", "\n", "x", "# HELP a\n# TYPE a"}) {
        EXPECT_NE(metrics_of_all({{"boat", text}}).find(text), std::string::npos) << text;
    }
}

}  // namespace
}  // namespace tribus::web::metrics_of_all_test
