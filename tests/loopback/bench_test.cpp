#include <poll.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/loopback/loopback.h"

namespace tribus::test::bench_test {
namespace {

class Bench : public Loopback {};

TEST_F(Bench, MeasuresAllInAShortTime) {
    Program& program = start({"bench", "--seconds", "1"});
    EXPECT_EQ(program.end(), 0) << program.errors();
    const std::string output = program.output();
    EXPECT_EQ(count_of("p50 ", output), 2U) << output;
    EXPECT_EQ(count_of("\na frame ", output), 1U) << output;
    EXPECT_EQ(program.errors().find("\x1b"), std::string::npos) << "progress without a terminal";
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
    EXPECT_EQ(rows.size(), 4U) << json;
}

TEST_F(Bench, FailsWhereARequirementDoesNotHold) {
    Program& program =
        start({"bench", "--seconds", "0.5", "--only", "cpu", "--require", "p50=1us"});
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

/// Carries what is written to the device `out` to the device `in`.
class Wire {
  public:
    Wire(FarEnd& out, FarEnd& in) : out_(out), in_(in), thread_([this] { carry(); }) {}
    Wire(const Wire&) = delete;
    Wire& operator=(const Wire&) = delete;
    ~Wire() {
        ends_ = true;
        thread_.join();
    }

  private:
    void carry() {
        while (!ends_) {
            pollfd wait{.fd = out_.descriptor(), .events = POLLIN, .revents = 0};
            ::poll(&wait, 1, 20);
            in_.send(out_.receive());
        }
    }

    FarEnd& out_;
    FarEnd& in_;
    std::atomic<bool> ends_{false};
    std::thread thread_;
};

TEST_F(Bench, MeasuresTwoWiredPorts) {
    FarEnd& out = device("out");
    FarEnd& in = device("in");
    const Wire wire(out, in);
    Program& program = start(
        {"bench", "--seconds", "1", "--only", "latency,cpu", "--ports", in.path(), out.path()});
    EXPECT_EQ(program.end(), 0) << program.errors();
    EXPECT_EQ(count_of("p50 ", program.output()), 1U) << program.output();
}

TEST_F(Bench, SaysThatNoWireIsBetweenThePorts) {
    const std::string out = device("out").path();
    const std::string in = device("in").path();
    Program& program = start({"bench", "--ports", in, out});
    EXPECT_EQ(program.end(), 1);
    EXPECT_EQ(
        count_of("no frame that was written on " + out + " came in on " + in, program.errors()), 1U)
        << program.errors();
}

TEST_F(Bench, EndsByCtrlC) {
    Program& program = start({"bench", "--seconds", "3000"});
    const std::string tasks = "/proc/" + std::to_string(program.pid()) + "/task";
    ASSERT_TRUE(eventually([&] {
        return std::ranges::any_of(std::filesystem::directory_iterator(tasks), [](auto& task) {
            std::string name;
            return std::ifstream(task.path() / "comm") >> name && name == "tribus-data";
        });
    }));
    program.signal(SIGINT);
    EXPECT_EQ(program.end(), 130) << program.errors();
    EXPECT_EQ(count_of("interrupted\n", program.errors()), 1U) << program.errors();
}

}  // namespace
}  // namespace tribus::test::bench_test
