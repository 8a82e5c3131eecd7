#include <sys/socket.h>

#include <array>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "app/daemon/metrics_server.h"
#include "app/status/metrics_text.h"
#include "config/load.h"
#include "tests/support/temporary_folder.h"

namespace tribus::metrics_test {
namespace {

constexpr const char* kConfig = R"([input.main]
protocol = "ibus"
device   = "/dev/tty\"A\\2"
[output.servos]
protocol = "sbus"
device   = "/dev/ttyAMA3"
[pipeline.car]
from = "main"
to   = "servos"
)";

class Metrics : public testing::Test {
  protected:
    Metrics() : configuration_(*load_configuration(kConfig, "car.toml")) {
        report_.configuration = &configuration_;
        report_.now = Instant(std::chrono::seconds(100));
        report_.started = Instant(std::chrono::seconds(90));
        report_.figures_at = Instant(std::chrono::milliseconds(99'950));
        report_.inputs.resize(1);
        report_.inputs[0].status.counts.frames = 42;
        report_.inputs[0].reject_causes = {"checksum"};
        report_.inputs[0].status.rejected_by = {3};
        report_.outputs.resize(1);
        report_.ports = {{"/dev/tty\"A\\2\n", true, {}},
                         {"can0", false, CanLinkStatus{CanBusState::bus_off, {}}}};
        const NamedValue value{.name = "pack.voltage", .unit = "V", .lasts = kForever};
        report_.values = {
            {value, {.number = 12.5, .at = report_.now, .ever = true, .available = true}},
            {value, {}}};
    }
    bool tells(const std::string& line) const {
        return ("\n" + metrics_text(report_)).find("\n" + line + "\n") != std::string::npos;
    }

    Configuration configuration_;
    StatusReport report_;
};

TEST_F(Metrics, CountByName) {
    EXPECT_TRUE(tells("tribus_input_frames_total{input=\"main\"} 42")) << metrics_text(report_);
    EXPECT_TRUE(tells("tribus_input_rejected_total{input=\"main\",cause=\"checksum\"} 3"));
    EXPECT_TRUE(tells("tribus_output_in_control{output=\"servos\"} 0"));
    EXPECT_TRUE(tells("tribus_figures_age_seconds 0.05"));
}

TEST_F(Metrics, EscapeWhatStandsInLabels) {
    EXPECT_TRUE(tells(R"(tribus_port_present{port="/dev/tty\"A\\2\n"} 1)"))
        << metrics_text(report_);
}

/// A value without a fresh number has no sample, because the last one would be stale.
TEST_F(Metrics, LeaveOutValuesThatAreStale) {
    EXPECT_TRUE(tells("tribus_value{name=\"pack.voltage\",unit=\"V\"} 12.5"));
    const std::string text = metrics_text(report_);
    EXPECT_EQ(text.find("tribus_value{"), text.rfind("tribus_value{"));
}

/// Grammar of prometheus.io/docs/instrumenting/exposition_formats, text format 0.0.4.
TEST_F(Metrics, KeepToTheGrammar) {
    const std::regex help("# HELP ([a-zA-Z_:][a-zA-Z0-9_:]*) .+");
    const std::regex type("# TYPE ([a-zA-Z_:][a-zA-Z0-9_:]*) (counter|gauge)");
    const std::regex sample(
        "([a-zA-Z_:][a-zA-Z0-9_:]*)"
        "(\\{[a-zA-Z_][a-zA-Z0-9_]*=\"([^\"\\\\]|\\\\[\\\\n\"])*\""
        "(,[a-zA-Z_][a-zA-Z0-9_]*=\"([^\"\\\\]|\\\\[\\\\n\"])*\")*\\})?"
        " (NaN|[+-]?Inf|[+-]?[0-9.]+(e[+-]?[0-9]+)?)");
    std::set<std::string> families;
    std::string family;
    std::string kind;
    std::istringstream text(metrics_text(report_));
    for (std::string line; std::getline(text, line);) {
        std::smatch match;
        if (std::regex_match(line, match, help)) {
            EXPECT_TRUE(families.insert(match[1]).second) << "twice: " << line;
            family = match[1];
        } else if (std::regex_match(line, match, type)) {
            EXPECT_EQ(match[1], family);
            kind = match[2];
            EXPECT_EQ(family.ends_with("_total"), kind == "counter") << line;
        } else {
            ASSERT_TRUE(std::regex_match(line, match, sample)) << line;
            EXPECT_EQ(match[1], family) << line;
        }
    }
    EXPECT_GT(families.size(), 20U);
}

std::string answer_to(const std::string& head, HostNames allowed = HostNames::own) {
    return http_response(head, allowed, [] { return std::string("tribus_uptime_seconds 1\n"); });
}

TEST(MetricsHttp, AnswersGetMetricsOnly) {
    EXPECT_EQ(answer_to("GET /metrics HTTP/1.1\r\nHost: 127.0.0.1:9464\r\n\r\n"),
              "HTTP/1.1 200 OK\r\nContent-Type: text/plain; version=0.0.4; charset=utf-8\r\n"
              "Content-Length: 24\r\nConnection: close\r\n\r\ntribus_uptime_seconds 1\n");
    EXPECT_TRUE(answer_to("GET / HTTP/1.1\r\n\r\n").starts_with("HTTP/1.1 404 "));
    EXPECT_TRUE(answer_to("POST /metrics HTTP/1.1\r\n\r\n").starts_with("HTTP/1.1 405 "));
    EXPECT_TRUE(answer_to("\r\n\r\n").starts_with("HTTP/1.1 400 "));
    EXPECT_TRUE(answer_to("GET /metrics\r\n\r\n").starts_with("HTTP/1.1 400 "));
}

/// A page from elsewhere may use a name that leads to this machine, and read the answer.
TEST(MetricsHttp, IsAskedByAddressOrAsLocalhost) {
    const auto asked_as = [](const std::string& host, HostNames allowed = HostNames::own) {
        return answer_to("GET /metrics HTTP/1.1\r\nAccept: */*\r\nhOST:" + host + "\r\n\r\n",
                         allowed)
            .substr(9, 3);
    };
    for (const char* host :
         {" localhost", " LocalHost:9464 ", "127.0.0.1", " [::1]:9464", " 192.168.1.2:9464"}) {
        EXPECT_EQ(asked_as(host), "200") << host;
    }
    for (const char* host : {" evil.example", " evil.example:9464", "", " 127.0.0.1.evil.example",
                             " localhost.evil.example", " [evil]:1"}) {
        EXPECT_EQ(asked_as(host), "421") << host;
    }
    EXPECT_EQ(asked_as(" board.local:9464", HostNames::any), "200");
    EXPECT_EQ(answer_to("GET /metrics HTTP/1.0\r\n\r\n").substr(9, 3), "200");
}

class MetricsSocket : public testing::Test {
  protected:
    std::unique_ptr<MetricsServer> serve() {
        auto server = MetricsServer::open(folder_ / "metrics", MetricsReach::local,
                                          [] { return std::string(3'000'000, 'x'); });
        EXPECT_TRUE(server) << server.error();
        return std::move(*server);
    }
    static void say(const UniqueFd& socket, const std::string& text) {
        ::send(socket.get(), text.data(), text.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    }

    test::TemporaryFolder folder_;
    Instant now_{std::chrono::hours(1)};
};

TEST_F(MetricsSocket, DropsOneWhoDoesNotReadAndOneWhoDoesNotEnd) {
    const auto server = serve();
    const auto silent = connect_local(folder_ / "metrics");
    const auto endless = connect_local(folder_ / "metrics");
    say(*silent, "GET /metrics HTTP/1.1\r\n\r\n");
    say(*endless, "GET /metrics HTTP/1.1\r\nX: ");
    server->serve(now_);
    EXPECT_EQ(server->client_count(), 2U);
    server->serve(now_ + std::chrono::seconds(5));
    EXPECT_EQ(server->client_count(), 0U);
}

TEST_F(MetricsSocket, DropsOneWhoSendsAByteNowAndThen) {
    const auto server = serve();
    const auto endless = connect_local(folder_ / "metrics");
    for (int second = 0; second < 10; ++second) {
        say(*endless, "x");
        server->serve(now_ + std::chrono::seconds(second));
        EXPECT_EQ(server->client_count(), 1U);
    }
    server->serve(now_ + std::chrono::seconds(10));
    EXPECT_EQ(server->client_count(), 0U);
}

TEST_F(MetricsSocket, AnswersBesideThirtyWhoAskSlowly) {
    const auto server = serve();
    std::vector<UniqueFd> slow;
    for (int i = 0; i < 30; ++i) {
        auto client = connect_local(folder_ / "metrics");
        ASSERT_TRUE(client);
        say(*client, "GET /metrics HTTP/1.1\r\nX: ");
        server->serve(now_);
        slow.push_back(std::move(*client));
    }
    const auto client = connect_local(folder_ / "metrics");
    say(*client, "GET /metrics HTTP/1.1\r\n\r\n");
    server->serve(now_);
    std::array<char, 64> bytes{};
    ASSERT_GT(::recv(client->get(), bytes.data(), bytes.size() - 1, MSG_DONTWAIT), 0);
    EXPECT_TRUE(std::string(bytes.data()).starts_with("HTTP/1.1 200 ")) << bytes.data();
}

TEST_F(MetricsSocket, RefusesAHeadWithoutEnd) {
    const auto server = serve();
    const auto client = connect_local(folder_ / "metrics");
    say(*client, std::string(20000, 'x'));
    for (int i = 0; i < 10; ++i) {
        server->serve(now_);
    }
    std::array<char, 64> bytes{};
    ASSERT_GT(::recv(client->get(), bytes.data(), bytes.size() - 1, MSG_DONTWAIT), 0);
    EXPECT_TRUE(std::string(bytes.data()).starts_with("HTTP/1.1 431 ")) << bytes.data();
}

TEST_F(MetricsSocket, AddressOfTheNetworkNeedsToBeWanted) {
    const auto none = [] { return std::string(); };
    const auto refused = MetricsServer::open("0.0.0.0:0", MetricsReach::local, none);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error(),
              "0.0.0.0:0 can be reached from the network, and nothing asks who reads; use "
              "127.0.0.1 or [::1], or allow it with --metrics-public");
    EXPECT_TRUE(MetricsServer::open("0.0.0.0:0", MetricsReach::network, none));
    EXPECT_TRUE(MetricsServer::open("127.0.0.1:0", MetricsReach::local, none));
}

TEST_F(MetricsSocket, AddressThatIsNoneIsRefused) {
    for (const char* address :
         {"", "9464", "localhost:1", "::1:9464", "127.0.0.1:", "x/y", "127.0.0.1:99999",
          "127.0.0.1:65536", "127.0.0.1:-1", "127.0.0.1:1x"}) {
        EXPECT_FALSE(MetricsServer::open(address, MetricsReach::local, [] {
            return std::string();
        })) << address;
    }
}

}  // namespace
}  // namespace tribus::metrics_test
