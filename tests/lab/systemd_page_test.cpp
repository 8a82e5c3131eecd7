#include <optional>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/lab/installed.h"
#include "tests/loopback/browser.h"

/// The page of the package: started by its socket, confined, and what it may write.
namespace tribus::test::systemd_page_test {
namespace {

constexpr int kPagePort = 8480;

class InstalledPage : public InstalledService {
  protected:
    ~InstalledPage() override {
        run_shell(
            "systemctl stop tribus-web.service; rm -f /var/lib/tribus-web/*.json; "
            "chgrp root /etc/tribus; chmod g-w /etc/tribus");
    }
    static Browser paired() {
        Browser browser(kPagePort);
        std::string code = shell("tribus pair").substr(0, 9);
        const BrowserAnswer answer = browser.pair(code.erase(4, 1));
        EXPECT_EQ(answer.status, 200) << answer.content;
        return browser;
    }
    /// Asks for the configuration with one more line, while no daemon runs it.
    static BrowserAnswer save(const Browser& browser) {
        const BrowserAnswer before = browser.get("/api/servos/configuration");
        return browser.post("/api/servos/save", {{"toml", before.content + "\n"}},
                            {{"If-Match", before.header("ETag")}});
    }
};

TEST_F(InstalledPage, StartsWhenSomebodyAsksAndHasAUserOfItsOwn) {
    EXPECT_EQ(property("ActiveState", "tribus-web.service"), "inactive");
    const BrowserAnswer answer = Browser(kPagePort).get("/");
    EXPECT_EQ(answer.status, 200) << answer.content;
    EXPECT_NE(answer.content.find("<script"), std::string::npos) << answer.content;
    EXPECT_EQ(property("ActiveState", "tribus-web.service"), "active");
    EXPECT_EQ(shell("ps -o user:20=,group:20= -C tribus-web | tr -s ' '"), "tribus-web tribus\n");
}

TEST_F(InstalledPage, HasUnitsThatAreRightAndClosed) {
    EXPECT_EQ(shell("systemd-analyze verify --man=no tribus-web.socket tribus-web.service "
                    "tribus-ports.socket tribus-ports@0.service tribus-pairing.service "
                    "tribus-pairing.path tribus-pairing.timer tribus-mqtt.service"),
              "");
    shell("systemd-analyze security --no-pager --threshold=20 tribus-ports@0.service");
    shell("systemd-analyze security --no-pager --threshold=15 tribus-web.service");
}

TEST_F(InstalledPage, ShowsADaemonToABrowserThatHasTheCode) {
    EXPECT_TRUE(carries(1200, 1200)) << journal();
    EXPECT_EQ(Browser(kPagePort).get("/api/servos/status").status, 401);
    EXPECT_EQ(paired().get("/api/servos/status").json()["inputs"][0]["name"], "receiver");
}

TEST_F(InstalledPage, KeepsADraftThatWasTriedSoThatTheDaemonCanReadIt) {
    EXPECT_TRUE(carries(1200, 1200)) << journal();
    shell("chmod 640 /etc/tribus/servos.toml; chgrp tribus /etc/tribus/servos.toml");
    const Browser browser = paired();
    const BrowserAnswer before = browser.get("/api/servos/configuration");
    const std::string draft =
        before.content + "[pipeline.main.channels]\n1 = { from = 1, reverse = true }\n";
    const auto tried = browser
                           .post("/api/servos/draft", {{"toml", draft}, {"seconds", 60}},
                                 {{"If-Match", before.header("ETag")}})
                           .json();
    ASSERT_EQ(tried["taken"], true) << tried;
    EXPECT_TRUE(carries(1200, 1800)) << journal();
    const BrowserAnswer kept = browser.post("/api/servos/confirm", {{"trial", tried["trial"]}});
    EXPECT_EQ(kept.status, 200) << kept.content;
    EXPECT_EQ(shell("stat -c %U:%G:%a /etc/tribus/servos.toml"), "tribus-web:tribus:640\n");
    shell("systemctl restart " + kUnit);
    EXPECT_TRUE(carries(1200, 1800)) << journal();
}

TEST_F(InstalledPage, MayWriteNoConfigurationAnyMoreWhenItsLastBrowserLeaves) {
    const std::string before = shell("stat -c %G:%a /etc/tribus");
    const Browser browser = paired();
    EXPECT_EQ(shell("stat -c %G:%a /etc/tribus"), "tribus-web:775\n");
    EXPECT_EQ(browser.post("/leave", nlohmann::json::object()).status, 200);
    EXPECT_TRUE(in_time([&] { return shell("stat -c %G:%a /etc/tribus") == before; }));
}

TEST_F(InstalledPage, AsksASocketThatOnlyTellsAndReadsNoKey) {
    EXPECT_TRUE(carries(1200, 1200)) << journal();
    EXPECT_EQ(shell("stat -c %U:%G:%a /run/tribus-look/servos.look"), "tribus:tribus-look:660\n");
    EXPECT_EQ(
        shell("runuser -u nobody -g nogroup -G tribus-look -- tribus status servos | head -c 6"),
        "servos");
    EXPECT_NE(
        run_shell("runuser -u nobody -g nogroup -G tribus-look -- tribus reload servos").status, 0);
}

/// The package gives the page no right to write configurations; `tribus pair` does.
TEST_F(InstalledPage, ChangesNoConfigurationBeforeABrowserMay) {
    shell("systemctl stop " + kUnit);
    const Browser browser = paired();
    shell("chgrp root /etc/tribus; chmod g-w /etc/tribus");
    EXPECT_EQ(save(browser).status, 500);
    shell("tribus pair --look");
    EXPECT_EQ(save(browser).status, 500);
    shell("tribus pair");
    EXPECT_EQ(save(browser).status, 200);
}

TEST_F(InstalledPage, ListsDrawsAndSendsARecording) {
    configure("[recorder]\n");
    shell("systemctl restart " + kUnit);
    EXPECT_TRUE(carries(1200, 1200)) << journal();
    const Browser browser = paired();
    ASSERT_EQ(browser.post("/api/servos/record", nlohmann::json::object()).status, 200);
    nlohmann::json list;
    ASSERT_TRUE(in_time([&] {
        list = browser.get("/api/servos/recordings").json()["recordings"];
        return list.is_array() && !list.empty();
    })) << list;
    const std::string path = "/api/servos/recordings/" + list[0]["id"].get<std::string>();
    const BrowserAnswer drawn = browser.get(path + "/plot?from=0&to=3700000000&width=100");
    EXPECT_EQ(drawn.status, 200) << drawn.content;
    EXPECT_NE(drawn.content.find(R"("name":"receiver")"), std::string::npos) << drawn.content;
    EXPECT_EQ(browser.get(path + ".tar").status, 200);
    // A recording stays when the package is removed.
    shell("systemctl stop " + kUnit + "; rm -r /var/lib/tribus/servos");
}

TEST_F(InstalledPage, DoctorOpensAPortByItsHelper) {
    shell("systemctl stop " + kUnit);
    const auto report =
        paired().post("/api/doctor", {{"device", uart_16550(1)}, {"seconds", 3}}).json();
    ASSERT_EQ(report["ports"].size(), 1U) << report;
    EXPECT_EQ(report["ports"][0]["tried"], true) << report;
    EXPECT_EQ(report["ports"][0]["heard"]["bytes"], 0) << report;
}

TEST_F(InstalledPage, TheServiceGoesOnWhileThePageIsFloodedAndKilled) {
    EXPECT_TRUE(carries(1200, 1200)) << journal();
    EXPECT_EQ(paired().get("/api/servos/status").status, 200);
    shell("for i in $(seq 200); do (echo x > /dev/tcp/127.0.0.1/8480) & done; wait");
    shell("systemctl kill -s KILL tribus-web.service");
    EXPECT_TRUE(carries(1800, 1800)) << journal();
    EXPECT_TRUE(in_time([] { return Browser(kPagePort).get("/").status == 200; }));
}

class PageSandbox : public testing::Test {
  protected:
    static void SetUpTestSuite() {
        install();
        shell("install -d /etc/tribus/keys");
        tried_.emplace("tribus-web.service", "", "/var/lib/tribus-web/tried",
                       "try serial 'head -c 1 /dev/ttyS0'\n"
                       "try others 'ls -d /proc/1'\n"
                       "try keys 'ls /etc/tribus/keys'\n"
                       "try realtime 'chrt -f 1 true'\n");
        shell("rmdir /etc/tribus/keys");
    }

    static inline std::optional<TriedSandbox> tried_;
};

TEST_F(PageSandbox, HasNoPrivileges) {
    EXPECT_EQ(tried_->of("rights"), kNoRights);
    EXPECT_TRUE(tried_->says("realtime", "Operation not permitted")) << tried_->of("realtime");
    EXPECT_TRUE(tried_->says("namespace", "Operation not permitted")) << tried_->of("namespace");
}

TEST_F(PageSandbox, SeesNothingOfHomesAndOtherProcesses) {
    EXPECT_TRUE(tried_->says("home", "cat: ")) << tried_->of("home");
    EXPECT_FALSE(tried_->says("home", "treasure")) << tried_->of("home");
    EXPECT_TRUE(tried_->says("others", "No such file")) << tried_->of("others");
}

TEST_F(PageSandbox, SeesNoKeys) {
    EXPECT_TRUE(tried_->says("keys", "Permission denied")) << tried_->of("keys");
}

TEST_F(PageSandbox, WritesNowhereButIntoItsFolders) {
    EXPECT_TRUE(tried_->says("system", "Read-only file system")) << tried_->of("system");
}

TEST_F(PageSandbox, HasNoInternetAndNoDevice) {
    EXPECT_TRUE(tried_->says("internet", "Address family not supported")) << tried_->of("internet");
    EXPECT_TRUE(tried_->says("disk", "No such file")) << tried_->of("disk");
    EXPECT_TRUE(tried_->says("serial", "No such file")) << tried_->of("serial");
}

}  // namespace
}  // namespace tribus::test::systemd_page_test
