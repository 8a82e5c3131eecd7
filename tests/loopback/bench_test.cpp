#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/loopback/loopback.h"

namespace tribus::test::bench_test {
namespace {

/// Returns the number of processes whose command line begins with the program under test.
std::size_t programs_at_work() {
    namespace fs = std::filesystem;
    std::size_t count = 0;
    for (const auto& process : fs::directory_iterator("/proc")) {
        std::ifstream file(process.path() / "cmdline");
        const std::string line{std::istreambuf_iterator<char>(file), {}};
        const bool ours = line.starts_with("/proc/self/exe") && line.find("run") != line.npos;
        count += ours ? 1U : 0U;
    }
    return count;
}

class Bench : public Loopback {};

TEST_F(Bench, MeasuresInAShortTimeAndLeavesNoProcess) {
    Program& program = start({"bench", "--seconds", "1", "--only", "codecs,latency"});
    EXPECT_EQ(program.end(), 0) << program.errors();
    const std::string output = program.output();
    EXPECT_EQ(count_of("p50 ", output), 1U) << output;
    EXPECT_EQ(count_of("sbus decode", output), 1U) << output;
    EXPECT_EQ(program.errors().find("\x1b"), std::string::npos) << "progress without a terminal";
    EXPECT_EQ(programs_at_work(), 0U);
}

TEST_F(Bench, LosesNoFrame) {
    Program& program = start({"bench", "--seconds", "1", "--only", "latency", "--format", "json"});
    EXPECT_EQ(program.end(), 0) << program.errors();
    const auto json = nlohmann::json::parse(program.output());
    const auto& rows = json.at("measurements");
    const auto lost = std::find_if(rows.begin(), rows.end(), [](const auto& row) {
        return row.at("what") == "frames lost or torn";
    });
    ASSERT_NE(lost, rows.end()) << json;
    EXPECT_EQ(lost->at("figure"), 0);
}

TEST_F(Bench, FailsWhereARequirementDoesNotHold) {
    Program& program =
        start({"bench", "--seconds", "0.5", "--only", "latency", "--require", "p50=1us"});
    EXPECT_EQ(program.end(), 1) << program.errors();
    EXPECT_EQ(count_of("p50=1us does not hold: the latency's p50 was ", program.output()), 1U);
}

TEST_F(Bench, RefusesARequirementThatItDoesNotKnow) {
    Program& program = start({"bench", "--require", "p98=1us"});
    EXPECT_EQ(program.end(), 2);
    EXPECT_EQ(count_of("--require p98=1us: ", program.errors()), 1U) << program.errors();
}

TEST_F(Bench, RefusesAMeasurementThatItDoesNotKnow) {
    Program& program = start({"bench", "--only", "latencies"});
    EXPECT_EQ(program.end(), 2);
    EXPECT_EQ(count_of("did you mean \"latency\"?", program.errors()), 1U) << program.errors();
}

TEST_F(Bench, DrawsTheDistributions) {
    const std::string plot = folder() / "plot.svg";
    Program& program =
        start({"bench", "--seconds", "0.5", "--only", "latency,lateness", "--plot", plot});
    EXPECT_EQ(program.end(), 0) << program.errors();
    std::ifstream file(plot);
    const std::string svg{std::istreambuf_iterator<char>(file), {}};
    EXPECT_EQ(count_of("<polyline", svg), 5U) << svg;
}

TEST_F(Bench, EndsByCtrlCAndLeavesNoProcess) {
    Program& program = start({"bench", "--seconds", "3000"});
    ASSERT_TRUE(eventually([] { return programs_at_work() == 1; }));
    program.signal(SIGINT);
    EXPECT_EQ(program.end(), 130) << program.errors();
    EXPECT_EQ(count_of("interrupted\n", program.errors()), 1U) << program.errors();
    EXPECT_EQ(programs_at_work(), 0U);
}

TEST_F(Bench, KilledOutrightLeavesNoProcessEither) {
    Program& program = start({"bench", "--seconds", "3000"});
    ASSERT_TRUE(eventually([] { return programs_at_work() == 1; }));
    program.signal(SIGKILL);
    EXPECT_TRUE(program.end());
    EXPECT_TRUE(eventually([] { return programs_at_work() == 0; }));
}

}  // namespace
}  // namespace tribus::test::bench_test
