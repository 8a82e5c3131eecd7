#include <sys/socket.h>

#include <algorithm>
#include <csignal>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "app/client/control_socket.h"
#include "tests/loopback/loopback.h"

namespace tribus::test::monitor_test {
namespace {

class Monitored : public Loopback {
  protected:
    std::string socket() const { return folder() / "control"; }
    Program& monitor(std::vector<std::string> arguments) {
        arguments.insert(arguments.begin(), {"monitor", "--socket", socket()});
        return start(arguments);
    }
    /// Returns the latest complete object that a monitor has printed.
    static nlohmann::json latest(const Program& monitor) {
        const std::string text = monitor.output();
        const std::size_t end = text.rfind('\n');
        const std::size_t before =
            end == std::string::npos || end == 0 ? std::string::npos : text.rfind('\n', end - 1);
        const std::size_t begin = before == std::string::npos ? 0 : before + 1;
        return nlohmann::json::parse(text.substr(begin, end - begin), nullptr, false);
    }

    FarEnd& receiver_ = device("receiver");
    ServoBank servos_{device("servos")};
    Repeater repeater_{receiver_, ibus_bytes(sticks_with_first(1234))};
    std::string config_ = write_config(main_job(kPatientInput));
};

TEST_F(Monitored, TellsWhatComesInAndWhatGoesOut) {
    Program& program = run(config_);
    Program& watching = monitor({"--format", "json", "--period", "50ms"});
    EXPECT_TRUE(eventually([&] {
        repeater_.send_if_due();
        servos_.listen();
        const auto status = latest(watching);
        return status.is_object() && status["inputs"][0]["state"] == "good" &&
               status["inputs"][0]["channels"][0] == 1234 &&
               status["outputs"][0]["state"] == "control" &&
               status["outputs"][0]["channels"][0] == 1234 &&
               status["outputs"][0]["lateness"]["count"] > 0;
    })) << watching.output()
        << watching.errors();
    expect_clean_end(program);
}

/// The daemon publishes figures ten times a second, mostly at the moment when a frame comes. The
/// monitor prints objects at any time between two frames.
TEST_F(Monitored, TellsHowOldTheNewestFrameIs) {
    Program& program = run(config_);
    Program& watching = monitor({"--format", "json", "--period", "50ms"});
    std::map<std::int64_t, std::int64_t> ages_us;
    EXPECT_TRUE(eventually([&] {
        repeater_.send_if_due();
        servos_.listen();
        const auto status = latest(watching);
        if (status.is_object() && status["inputs"][0]["age_us"].is_number()) {
            ages_us[status["t_us"].get<std::int64_t>()] =
                status["inputs"][0]["age_us"].get<std::int64_t>();
        }
        return ages_us.size() == 40;
    }));
    const auto none = std::ranges::count_if(ages_us, [](auto age) { return age.second == 0; });
    EXPECT_LE(none, 4) << "of 40 newest frames had no age";
    expect_clean_end(program);
}

TEST_F(Monitored, TellsSinceWhenTheProgramRunsAlsoBehindAReload) {
    Program& program = run(config_);
    Program& watching = monitor({"--format", "json", "--period", "50ms"});
    const auto uptime = [&] {
        const auto status = latest(watching);
        return status.is_object() ? status["uptime_us"].get<double>() : 0.0;
    };
    EXPECT_TRUE(eventually([&] { return uptime() > 1'000'000; }));
    program.signal(SIGHUP);
    EXPECT_TRUE(program.says("reloaded"));
    const std::size_t lines = count_of("\n", watching.output());
    EXPECT_TRUE(eventually([&] { return count_of("\n", watching.output()) > lines + 1; }));
    EXPECT_GT(uptime(), 1'000'000);
    expect_clean_end(program);
}

TEST_F(Monitored, IsFoundByItsName) {
    Program& program = run(config_);
    Program& once = start({"monitor", folder().filename().string(), "--once"});
    EXPECT_EQ(once.end(), 0) << once.errors();
    EXPECT_TRUE(once.output().starts_with("tribus  receiver never seen")) << once.output();
    expect_clean_end(program);
}

TEST_F(Monitored, NobodyThereIsAFailure) {
    Program& lonely = monitor({});
    EXPECT_EQ(lonely.end(), 1);
    EXPECT_EQ(lonely.errors().find("tribus: no daemon answers at " + socket()), 0U)
        << lonely.errors();
}

TEST_F(Monitored, ThatRestartsIsWaitedFor) {
    Program& first = run(config_);
    Program& watching = monitor({"--format", "json"});
    EXPECT_TRUE(eventually([&] { return latest(watching).is_object(); }));
    first.signal(SIGKILL);
    EXPECT_TRUE(watching.says("is gone; waiting for it"));
    first.end();
    const std::size_t before = count_of("\n", watching.output());
    Program& second = run(config_);
    EXPECT_TRUE(eventually([&] { return count_of("\n", watching.output()) > before; }));
    expect_clean_end(second);
    EXPECT_FALSE(std::filesystem::exists(socket()));
}

TEST_F(Monitored, ThatIsFrozenDoesNotLookAlive) {
    Program& program = run(config_);
    Program& watching = monitor({});
    EXPECT_TRUE(eventually([&] { return count_of("never seen", watching.output()) > 0; }));
    EXPECT_EQ(count_of("STANDS STILL", watching.output()), 0U);
    program.signal(SIGSTOP);
    EXPECT_TRUE(eventually([&] { return count_of("STANDS STILL", watching.output()) > 0; }));
    program.signal(SIGCONT);
    expect_clean_end(program);
}

TEST_F(Monitored, ASecondDaemonOnAGivenSocketIsRefused) {
    Program& first = run(config_);
    Program& second = start({"run", config_, "--socket", socket()});
    EXPECT_EQ(second.end(), 1);
    EXPECT_EQ(count_of("another program answers on " + socket(), second.errors()), 1U)
        << second.errors();
    expect_clean_end(first);
}

/// Sixteen clients never read, and one sends garbage without end.
TEST_F(Monitored, ClientsThatDoNotReadDoNotHurt) {
    Program& program = run(config_);
    std::deque<UniqueFd> clients;
    for (int i = 0; i < 16; ++i) {
        UniqueFd client;
        ASSERT_TRUE(eventually([&] {
            auto connected = connect_local(socket());
            client = connected ? std::move(*connected) : UniqueFd();
            return client.valid();
        }));
        const std::string request = i == 0 ? std::string(200, 'x') : "watch 50ms\n";
        ::send(client.get(), request.data(), request.size(), MSG_NOSIGNAL);
        clients.push_back(std::move(client));
    }
    const std::string garbage(65536, '\xA5');
    std::size_t seen = 0;
    EXPECT_TRUE(eventually([&] {
        ::send(clients.front().get(), garbage.data(), garbage.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
        repeater_.send_if_due();
        for (const auto& frame : servos_.listen()) {
            seen += frame.good() && frame.raw[0] == sbus_raw(1234) ? 1U : 0U;
        }
        return seen >= 100;
    })) << seen;
    expect_clean_end(program);
}

}  // namespace
}  // namespace tribus::test::monitor_test
