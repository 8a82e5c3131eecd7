#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/client/control_socket.h"
#include "tests/loopback/web.h"

/// Places of the page: where it listens, and the files that it writes.
namespace tribus::test::web_place_test {
namespace {

using nlohmann::json;
using WebPlace = Web;

TEST_F(WebPlace, IsServedAtALocalSocketForAProxy) {
    run_daemon();
    const std::string socket = folder() / "page.sock";
    Program& server = start({"serve", "--listen", socket, "--configurations", folder(), "--state",
                             folder() / "state", "--page", folder() / "page"},
                            {.executable = TRIBUS_WEB});
    EXPECT_TRUE(server.says("the page is at " + socket)) << server.errors();
    const auto connected = connect_local(socket);
    ASSERT_TRUE(connected);
    const std::string request = "GET / HTTP/1.1\r\nHost: localhost\r\n\r\n";
    ::send(connected->get(), request.data(), request.size(), MSG_NOSIGNAL);
    std::string received;
    EXPECT_TRUE(eventually([&] {
        std::array<char, 4096> bytes;
        const ssize_t count = ::recv(connected->get(), bytes.data(), bytes.size(), MSG_DONTWAIT);
        received.append(bytes.data(), static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
        return received.find("the page") != std::string::npos;
    })) << received;
    server.signal(SIGTERM);
    EXPECT_EQ(server.end(), 0);
    EXPECT_FALSE(std::filesystem::exists(socket));
}

TEST_F(WebPlace, AnAddressThatTheNetworkCanReachNeedsToBeAllowed) {
    const auto errors_at = [this](const std::string& address) {
        Program& server = start({"serve", "--listen", address}, {.executable = TRIBUS_WEB});
        EXPECT_EQ(server.end(), 1);
        return server.errors();
    };
    for (const std::string open : {"0.0.0.0:0", "[::]:0", "192.0.2.1:0"}) {
        EXPECT_NE(errors_at(open).find(open + " can be reached from the network"),
                  std::string::npos)
            << open;
    }
    for (const std::string wrong :
         {"127.0.0.1:", "127.0.0.1:99999", "127.0.0.1:a", "::1:80", "x"}) {
        EXPECT_NE(errors_at(wrong).find("allowed: \"127.0.0.1:8480\""), std::string::npos) << wrong;
    }
}

TEST_F(WebPlace, ThePageMayWriteConfigurationsWhileABrowserMayChangeThem) {
    if (::geteuid() != 0) {
        GTEST_SKIP() << "only root gives a folder a group";
    }
    constexpr uid_t kPage = 65534;
    const std::filesystem::path configurations = folder() / "configurations";
    std::filesystem::create_directory(configurations);
    ASSERT_EQ(::chmod(configurations.c_str(), 0755), 0);
    serve();
    ASSERT_EQ(::chown((folder() / "state").c_str(), kPage, kPage), 0);
    const auto place = [&] {
        struct stat found {};
        EXPECT_EQ(::stat(configurations.c_str(), &found), 0);
        return std::pair(found.st_gid, found.st_mode & 0777U);
    };
    const auto pair = [&](std::vector<std::string> more) {
        more.insert(more.end(), {"--configurations", configurations});
        Browser browser(port_);
        EXPECT_EQ(browser.pair(code(more)).status, 200);
    };
    pair({"--look"});
    EXPECT_EQ(place(), std::pair(gid_t{0}, 0755U));
    pair({});
    EXPECT_EQ(place(), std::pair(gid_t{kPage}, 0775U));
    Program& revoke = start({"pair", "--state", folder() / "state", "--revoke", "browser",
                             "--configurations", configurations});
    EXPECT_EQ(revoke.end(), 0) << revoke.errors();
    EXPECT_EQ(place(), std::pair(gid_t{kPage}, 0755U));
}

TEST_F(WebPlace, MetricsOfAllDaemonsNeedNoPairingButToBeSwitchedOn) {
    Program& daemon = run_daemon();
    Program& without = serve();
    EXPECT_EQ(Browser(port_).get("/metrics").status, 404);
    without.signal(SIGTERM);
    EXPECT_EQ(without.end(), 0);
    std::filesystem::copy_file(file(), folder() / "absent.toml");
    serve({"--metrics"});
    const BrowserAnswer answer = Browser(port_).get("/metrics");
    EXPECT_EQ(answer.header("Content-Type"), "text/plain; version=0.0.4; charset=utf-8");
    for (const std::string& line :
         {std::string("tribus_daemon_answers{daemon=\"absent\"} 0"),
          "tribus_daemon_answers{daemon=\"" + name() + "\"} 1",
          "tribus_input_good{daemon=\"" + name() + "\",input=\"receiver\"} 1"}) {
        EXPECT_NE(answer.content.find("\n" + line + "\n"), std::string::npos) << line << "\n"
                                                                              << answer.content;
    }
    daemon.signal(SIGSTOP);
    EXPECT_NE(Browser(port_).get("/metrics").content.find("{daemon=\"" + name() + "\"} 0\n"),
              std::string::npos);
    daemon.signal(SIGCONT);
}

TEST_F(WebPlace, KeepingLeavesALinkAndTheModeOfTheFile) {
    run_daemon();
    serve();
    const std::string real = folder() / "real.text";
    std::filesystem::rename(file(), real);
    std::filesystem::permissions(real, std::filesystem::perms(0640));
    std::filesystem::create_symlink("real.text", file());
    const Browser browser = paired();
    const json tried = try_reversed(browser).json();
    ASSERT_TRUE(tried["taken"]) << tried;
    EXPECT_EQ(post(browser, "confirm", {{"trial", tried["trial"]}}).status, 200);
    EXPECT_TRUE(std::filesystem::is_symlink(file()));
    EXPECT_NE(content().find(kReversed), std::string::npos);
    EXPECT_EQ(std::filesystem::status(real).permissions(), std::filesystem::perms(0640));
}

}  // namespace
}  // namespace tribus::test::web_place_test
