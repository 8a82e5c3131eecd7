#include <gtest/gtest.h>

#include <chrono>
#include <string>

#include "config/show/effective.h"
#include "tests/unit/config/main_job.h"

/// [recorder]
namespace tribus::test::recorder_test {
namespace {

using namespace std::chrono_literals;

std::string with_recorder(std::string_view lines) {
    return main_job_with(10, "[recorder]\n" + std::string(lines));
}

TEST(RecorderTable, ThatIsAbsentRecordsNothing) {
    const auto configuration = load_configuration(main_job_with(11, ""), "t.toml");
    ASSERT_TRUE(configuration);
    EXPECT_FALSE(configuration->recorder);
    EXPECT_EQ(effective_toml(*configuration).find("recorder"), std::string::npos);
}

TEST(RecorderTable, ThatIsEmptyHasEveryDefault) {
    const auto configuration = load_configuration(with_recorder(""), "t.toml");
    ASSERT_TRUE(configuration);
    ASSERT_TRUE(configuration->recorder);
    EXPECT_EQ(configuration->recorder->directory, "");
    EXPECT_EQ(configuration->recorder->memory_kib, 1024);
    EXPECT_EQ(configuration->recorder->before, 30s);
    EXPECT_EQ(configuration->recorder->after, 2s);
    EXPECT_TRUE(configuration->recorder->on_failsafe);
    EXPECT_EQ(configuration->recorder->pause, 60s);
    EXPECT_EQ(configuration->recorder->keep, 20);
    EXPECT_EQ(configuration->recorder->space_mib, 100);
}

TEST(RecorderTable, KeepsItsPlace) {
    const auto configuration = load_configuration(with_recorder(""), "t.toml");
    ASSERT_TRUE(configuration);
    EXPECT_EQ(configuration->recorder->where.line, 10U);
}

TEST(RecorderTable, MeansTheSameInItsEffectiveForm) {
    const auto configuration = load_configuration(with_recorder(R"(directory = "/data/tribus"
memory = 64
before = "5s"
after = "0s"
on_failsafe = false
pause = "0s"
keep = 3
space = 10)"),
                                                  "t.toml");
    ASSERT_TRUE(configuration);
    const auto again = load_configuration(effective_toml(*configuration), "t.toml");
    ASSERT_TRUE(again) << format_mistake(again.error().front());
    EXPECT_EQ(again->recorder, configuration->recorder);
    EXPECT_EQ(again->recorder->directory, "/data/tribus");
    EXPECT_EQ(again->recorder->keep, 3);
}

TEST(RecorderTable, WantsADirectoryThatDoesNotDependOnTheStart) {
    EXPECT_EQ(mistakes_in(with_recorder("directory = \"recordings\"")),
              std::vector<std::string>{"t.toml:11:13: \"directory\" must not depend on where the "
                                       "program is started; allowed: a path that begins with /"});
}

TEST(RecorderTable, IsATable) {
    EXPECT_EQ(mistakes_in("recorder = true\n" + main_job_with(11, "")),
              std::vector<std::string>{
                  "t.toml:1:12: \"recorder\" is true; allowed: a table, [recorder]"});
}

}  // namespace
}  // namespace tribus::test::recorder_test
