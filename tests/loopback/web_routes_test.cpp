#include <fstream>
#include <map>
#include <regex>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/loopback/web.h"
#include "tests/support/manual_routes.h"

/// Every address of the manual, asked with every method and origin by every kind of browser.
namespace tribus::test::web_routes_test {
namespace {

class WebRoutes : public Web {
  protected:
    /// The manual's table, with the names of this test.
    std::vector<ManualRoute> rows() const {
        std::vector<ManualRoute> all = manual_routes();
        for (ManualRoute& row : all) {
            row.path = std::regex_replace(row.path, std::regex("/N/"), "/" + name() + "/");
            row.path = std::regex_replace(row.path, std::regex("ID|NUMBER"), "1");
        }
        return all;
    }
    std::map<std::string, std::string> page_of(const std::string& origin) const {
        return {{"Content-Type", "application/json"}, {"X-Tribus", "1"}, {"Origin", origin}};
    }
};

TEST_F(WebRoutes, AreForNobodyButWhomTheManualNames) {
    run_daemon();
    serve({"--metrics"});
    const Browser stranger(port_);
    const Browser looks = paired({"--look"});
    const Browser changes = paired();
    const std::string own = "http://" + changes.host();
    ASSERT_GT(rows().size(), 25U);
    for (const auto& [method, path, who] : rows()) {
        const auto status = [&, method = method, path = path](const Browser& browser,
                                                              const std::string& origin) {
            const bool post = method == "POST";
            return browser
                .ask(method, path, post ? std::optional<std::string>("{}") : std::nullopt,
                     post ? page_of(origin) : std::map<std::string, std::string>{})
                .status;
        };
        if (who != "anybody") {
            EXPECT_EQ(status(stranger, own), 401) << method << path;
        }
        if (who == "changes") {
            EXPECT_EQ(status(looks, own), 403) << method << path;
        }
        if (method == "POST") {
            EXPECT_EQ(status(changes, "http://evil.example"), 403) << path;
            EXPECT_EQ(status(changes, "null"), 403) << path;
        }
    }
}

TEST_F(WebRoutes, HaveNoOtherMethods) {
    run_daemon();
    serve({"--metrics"});
    const Browser browser = paired();
    for (const auto& [method, path, who] : rows()) {
        for (const std::string other : {"GET", "POST", "PUT", "DELETE", "PATCH", "OPTIONS"}) {
            if (other != method) {
                EXPECT_EQ(browser
                              .ask(other, path,
                                   other == "GET" ? std::nullopt : std::optional<std::string>("{}"),
                                   page_of("http://" + browser.host()))
                              .status,
                          405)
                    << other << path;
            }
        }
    }
}

TEST_F(WebRoutes, SayWhichMethodIsAllowedAndGiveHeadNoContent) {
    serve();
    const Browser browser(port_);
    for (const std::string path : {"/", "/api/me"}) {
        const auto answer = browser.ask("HEAD", path, std::nullopt);
        EXPECT_EQ(answer.status, 405) << path;
        EXPECT_EQ(answer.header("Allow"), "GET") << path;
        EXPECT_EQ(answer.content, "") << path;
    }
    EXPECT_EQ(browser.ask("GET", "/pair", std::nullopt).header("Allow"), "POST");
}

TEST_F(WebRoutes, ThatNoRowHasAreNotThere) {
    run_daemon();
    serve();
    const Browser browser = paired();
    for (const std::string& path :
         {api("record/"), api("record/1/"), api("status/"), api("recordings/"), api("history/"),
          api("recordings//plot"), api(""), std::string("/api/"), std::string("/api/daemons/"),
          std::string("/api/me/x")}) {
        EXPECT_EQ(browser.get(path).status, 404) << path;
        EXPECT_EQ(browser.post(path, {{"trial", 1}}).status, 404) << path;
    }
    for (const char* const number : {"record/%20", "record/-1", "record/1%201", "record/x"}) {
        EXPECT_EQ(browser.get(api(number)).status, 404) << number;
    }
}

TEST_F(WebRoutes, FindAConfigurationWhoseNameHasBlanksAndUmlauts) {
    std::ofstream(folder() / "mein Böötchen.toml") << main_job();
    serve();
    const Browser browser = paired();
    const auto answer = browser.get("/api/mein%20B%C3%B6%C3%B6tchen/configuration");
    EXPECT_EQ(answer.status, 200);
    EXPECT_EQ(answer.content, main_job());
}

}  // namespace
}  // namespace tribus::test::web_routes_test
