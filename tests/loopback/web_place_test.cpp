#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/client/control_socket.h"
#include "app/daemon/control_server.h"
#include "pipelines/realtime/clock.h"
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

/// A folder of configurations of the group of somebody else, and the page of another user.
class PageThatWrites : public Web {
  protected:
    static constexpr uid_t kPage = 65534;
    static constexpr gid_t kBefore = 12345;

    void SetUp() override {
        if (::geteuid() != 0) {
            GTEST_SKIP() << "only root gives a folder a group";
        }
        std::filesystem::create_directory(configurations_);
        ASSERT_EQ(::chown(configurations_.c_str(), 0, kBefore), 0);
        ASSERT_EQ(::chmod(configurations_.c_str(), 0750), 0);
        serve();
        ASSERT_EQ(::chown((folder() / "state").c_str(), kPage, kPage), 0);
    }
    std::pair<gid_t, unsigned> place() const {
        struct stat found {};
        EXPECT_EQ(::stat(configurations_.c_str(), &found), 0);
        return {found.st_gid, found.st_mode & 0777U};
    }
    std::vector<std::string> with_folder(std::vector<std::string> more = {}) const {
        more.insert(more.end(), {"--configurations", configurations_});
        return more;
    }
    Browser paired_here(std::vector<std::string> more = {}) {
        return paired(with_folder(std::move(more)));
    }
    int pair(std::vector<std::string> more) {
        more.insert(more.begin(), {"pair", "--state", folder() / "state"});
        Program& program = start(with_folder(std::move(more)));
        EXPECT_EQ(program.end(), 0) << program.errors();
        return 0;
    }
    std::string sessions() const { return folder() / "state/sessions.json"; }

    std::filesystem::path configurations_ = folder() / "configurations";
    const std::pair<gid_t, unsigned> open_{kPage, 0770U};
    const std::pair<gid_t, unsigned> closed_{kBefore, 0750U};
};

TEST_F(PageThatWrites, BeginsWithABrowserThatMayChangeAndEndsWhenItIsRevoked) {
    paired_here({"--look"});
    EXPECT_EQ(place(), closed_);
    paired_here();
    EXPECT_EQ(place(), open_);
    paired_here();
    pair({"--close"});
    EXPECT_EQ(place(), open_) << "somebody may change";
    pair({"--revoke", "browser"});
    EXPECT_EQ(place(), closed_);
}

TEST_F(PageThatWrites, EndsWhenItsLastBrowserLeaves) {
    const Browser browser = paired_here();
    EXPECT_EQ(browser.post("/leave", json::object()).status, 200);
    pair({"--close"});
    EXPECT_EQ(place(), closed_);
}

TEST_F(PageThatWrites, EndsWhenItsLastBrowserHasExpired) {
    paired_here();
    std::ifstream in(sessions());
    json all = json::parse(in);
    all[0]["made"] = all[0]["made"].get<std::int64_t>() - 90 * 24 * 3600;
    std::ofstream(sessions()) << all;
    pair({"--close"});
    EXPECT_EQ(place(), closed_);
}

TEST_F(PageThatWrites, EndsWhenItsFileIsGoneOrNoFile) {
    paired_here();
    std::filesystem::remove(sessions());
    pair({"--close"});
    EXPECT_EQ(place(), closed_);
    paired_here();
    std::filesystem::remove(sessions());
    ASSERT_EQ(::mkfifo(sessions().c_str(), 0666), 0);
    pair({"--close"});
    EXPECT_EQ(place(), closed_);
}

TEST_F(PageThatWrites, EndsWithACodeThatNobodyUsed) {
    code(with_folder());
    EXPECT_EQ(place(), open_);
    pair({"--look"});
    EXPECT_EQ(place(), closed_) << "the new code may only look";
    code(with_folder());
    std::filesystem::remove(folder() / "state/code.json");
    pair({"--close"});
    EXPECT_EQ(place(), closed_);
}

/// What the page wrote there is not believed.
TEST_F(PageThatWrites, EndsAsThePackageMadeItWhereNothingWasKept) {
    paired_here();
    const std::string kept = folder() / "state.before";
    ASSERT_TRUE(std::filesystem::exists(kept));
    std::ofstream(kept) << kPage << " 777";
    ASSERT_EQ(::chown(kept.c_str(), kPage, kPage), 0);
    pair({"--revoke", "browser"});
    EXPECT_EQ(place(), std::pair(gid_t{0}, 0750U));
}

/// A daemon that somebody took over names another file for the draft.
TEST_F(WebPlace, ADraftIsWrittenBesideTheSocketWhateverTheDaemonSays) {
    write_config(main_job(kPatientInput), name() + ".toml");
    const std::string elsewhere = folder() / "elsewhere";
    auto control = ControlServer::open(folder() / "control");
    ASSERT_TRUE(control) << control.error();
    std::filesystem::create_directory(folder() / "draft");
    (*control)->add("draft", [&](auto) {
        return json{{"type", "draft"}, {"file", elsewhere}}.dump();
    });
    (*control)->add("reload", [](auto) {
        return json{{"type", "outcome"}, {"taken", true}, {"lines", json::array()}, {"trial", 1}}
            .dump();
    });
    std::atomic<bool> ends{false};
    std::thread serves([&] {
        while (!ends) {
            (*control)->serve(monotonic_now());
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
    });
    serve();
    const BrowserAnswer tried = try_reversed(paired());
    ends = true;
    serves.join();
    EXPECT_EQ(tried.status, 200) << tried.content;
    EXPECT_FALSE(std::filesystem::exists(elsewhere));
    EXPECT_TRUE(std::filesystem::exists(folder() / "draft/draft.toml"));
}

/// The page has no key: it judges a configuration as if its key files were there.
TEST_F(WebPlace, AConfigurationWithAKeyIsJudgedWithoutTheKey) {
    write_config(
        "[input.shore]\nprotocol = \"network\"\naddress = \"127.0.0.1:5700\"\n"
        "key = \"/nowhere/boat.key\"\n[output.servos]\nprotocol = \"sbus\"\n"
        "device = \"@servos\"\n[pipeline.main]\nfrom = \"shore\"\nto = \"servos\"\n",
        name() + ".toml");
    serve();
    const BrowserAnswer judged = post(paired(), "check", {{"toml", content()}});
    EXPECT_EQ(judged.json()["mistakes"], json::array()) << judged.content;
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
