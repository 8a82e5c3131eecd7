#include <atomic>
#include <chrono>
#include <csignal>
#include <fstream>
#include <iterator>
#include <list>
#include <map>
#include <regex>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/loopback/browser.h"
#include "tests/loopback/web.h"

/// `tribus-web` in front of a real daemon on ptys, as browsers and those who pretend to be one see
/// it (docs/web.md).
namespace tribus::test::web_test {
namespace {

using nlohmann::json;

TEST_F(Web, GivesThePageToAllAndNothingElseWithoutPairing) {
    run_daemon();
    serve();
    const Browser stranger(port_);
    EXPECT_EQ(stranger.get("/").content, "the page");
    EXPECT_EQ(stranger.get("/api/me").json()["role"], nullptr);
    for (const std::string& path :
         {std::string("/api/daemons"), api("status"), api("configuration"), api("schema"),
          api("graph.svg"), api("history"), api("stream"), std::string("/api/none/status")}) {
        EXPECT_EQ(stranger.get(path).status, 401) << path;
    }
    for (const std::string what : {"check", "diff", "draft", "confirm", "back", "save", "record"}) {
        EXPECT_EQ(stranger.post(api(what), {{"toml", ""}, {"trial", 1}}).status, 401) << what;
    }
}

TEST_F(Web, ACodePairsOneBrowserWhichThenSeesTheStatus) {
    run_daemon();
    serve();
    const std::string given = code();
    Browser browser(port_);
    const BrowserAnswer answer = browser.pair(given);
    EXPECT_EQ(answer.status, 200);
    EXPECT_NE(answer.header("Set-Cookie").find("HttpOnly; SameSite=Strict; Path=/"),
              std::string::npos);
    EXPECT_EQ(Browser(port_).pair(given).status, 410) << "used twice";
    EXPECT_EQ(browser.get("/api/me").json()["role"], "change");
    EXPECT_EQ(listed_state(browser), "running");
    EXPECT_EQ(browser.get(api("status")).json()["inputs"][0]["name"], "receiver");
    EXPECT_EQ(browser.post("/leave", json::object()).status, 200);
    EXPECT_EQ(browser.get(api("status")).status, 401);
}

TEST_F(Web, WhoTypesWrongCodesWaitsAndKeepsNobodyElseFromPairing) {
    const Program& server = serve();
    const std::string given = code();
    Browser stranger(port_, "127.0.0.2");
    const auto began = std::chrono::steady_clock::now();
    const BrowserAnswer wrong = stranger.post("/pair", {{"code", "AAAAAAAA"}});
    EXPECT_EQ(wrong.status, 403);
    EXPECT_EQ(wrong.json()["wait_s"], 1);
    EXPECT_EQ(wrong.header("Retry-After"), "1");
    const BrowserAnswer right = stranger.pair(given);
    if (std::chrono::steady_clock::now() - began < std::chrono::seconds(1)) {
        EXPECT_EQ(right.status, 429) << "the pause lasts for a right code too";
        EXPECT_EQ(Browser(port_).pair(given).status, 200);
    }
    EXPECT_TRUE(server.says("a wrong code came from 127.0.0.2; its next one counts after 1 s"));
}

TEST_F(Web, WrongCodesBehindAProxyOfTheBoardAreThoseOfWhomItSays) {
    const Program& server = serve();
    code();
    const Browser proxy(port_);
    EXPECT_EQ(
        proxy.post("/pair", {{"code", "AAAAAAAA"}}, {{"X-Forwarded-For", "203.0.113.9, 192.0.2.7"}})
            .status,
        403);
    EXPECT_TRUE(server.says("a wrong code came from 192.0.2.7; ")) << "the nearest one is last";
    EXPECT_EQ(
        proxy.post("/pair", {{"code", "AAAAAAAA"}}, {{"X-Forwarded-For", "192.0.2.8"}}).status,
        403);
}

TEST_F(Web, AStreamBringsEachStatusAndSaysWhenTheDaemonHangsAndIsBack) {
    Program& daemon = run_daemon();
    serve();
    const Browser browser = paired();
    EventStream stream(browser, port_, api("stream?rate=10"));
    std::int64_t before = 0;
    for (int i = 0; i < 5; ++i) {
        const auto status = stream.next("status");
        ASSERT_TRUE(status);
        const std::int64_t at = json::parse(*status)["t_us"];
        EXPECT_GT(at, before);
        before = at;
    }
    daemon.signal(SIGSTOP);
    const auto gone = stream.next("gone");
    ASSERT_TRUE(gone);
    EXPECT_EQ(json::parse(*gone)["reason"], "the daemon does not answer");
    daemon.signal(SIGCONT);
    EXPECT_TRUE(stream.next("status"));
    daemon.signal(SIGKILL);
    EXPECT_TRUE(stream.next("gone"));
    run(file());
    EXPECT_TRUE(stream.next("status"));
}

TEST_F(Web, AFifthStreamOfABrowserEndsItsFirstAndSaysSo) {
    run_daemon();
    serve();
    const Browser browser = paired();
    std::list<EventStream> streams;
    for (int i = 0; i < 5; ++i) {
        streams.emplace_back(browser, port_, api("stream"));
        EXPECT_TRUE(streams.back().next("status")) << i;
    }
    EXPECT_TRUE(streams.front().next("ended"));
    EXPECT_TRUE(streams.front().ended());
    for (auto stream = std::next(streams.begin()); stream != streams.end(); ++stream) {
        EXPECT_TRUE(stream->next("status"));
    }
}

TEST_F(Web, ARevokedBrowserGetsNothingMoreAlsoInAStream) {
    run_daemon();
    serve();
    const Browser browser = paired();
    EventStream stream(browser, port_, api("stream"));
    EXPECT_TRUE(stream.next("status"));
    Program& revoke = start({"pair", "--state", folder() / "state", "--revoke", "browser"});
    EXPECT_EQ(revoke.end(), 0);
    EXPECT_TRUE(stream.next("revoked"));
    EXPECT_TRUE(stream.ended());
    EXPECT_EQ(browser.get(api("status")).status, 401);
}

TEST_F(Web, ADraftIsCheckedComparedTriedAndKept) {
    Program& daemon = run_daemon();
    serve();
    const Browser browser = paired();
    const auto mistakes = post(browser, "check", {{"toml", "[input.a]\nprotocol = \"x\"\n"}});
    EXPECT_EQ(mistakes.json()["mistakes"][1]["line"], 2);
    EXPECT_EQ(mistakes.json()["mistakes"][1]["column"], 12);
    const auto difference = post(browser, "diff", {{"toml", reversed()}}).json();
    EXPECT_EQ(difference["lines"][1], "  channel 1: channel 1 before, now channel 1, reverse");
    EventStream stream(browser, port_, api("stream"));
    EXPECT_TRUE(stream.next("status"));
    const auto changed = post(browser, "diff", {{"toml", reversed()}}).json()["outputs"];
    EXPECT_EQ(changed.dump(),
              R"([{"channels":[{"channel":1,"now_us":1100,"then_us":1900}],"output":"servos"}])");
    const std::string before = content();
    const BrowserAnswer tried = try_reversed(browser);
    ASSERT_EQ(tried.status, 200) << tried.content;
    expect_first_channel(1900);
    EXPECT_EQ(content(), before) << "the file waits for the end of the trial";
    const auto trial = tried.json()["trial"];
    EXPECT_EQ(post(browser, "confirm", {{"trial", trial.get<int>() + 1}}).status, 409);
    const BrowserAnswer kept = post(browser, "confirm", {{"trial", trial}});
    ASSERT_EQ(kept.status, 200) << kept.content;
    EXPECT_EQ(content(), before + "\n" + kReversed + "\n");
    EXPECT_EQ(post(browser, "confirm", {{"trial", trial}}).status, 409);
    const auto history = browser.get(api("history")).json()["files"];
    ASSERT_EQ(history.size(), 1U);
    EXPECT_TRUE(std::regex_match(history[0]["time"].get<std::string>(),
                                 std::regex(R"(\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ)")))
        << history[0] << " is no time that a browser reads";
    EXPECT_EQ(browser.get(api("history/" + history[0]["id"].get<std::string>())).content, before);
    expect_first_channel(1900);
    expect_clean_end(daemon);
}

TEST_F(Web, ATrialGoesBackOnRequestAndNobodyKeepsItAfterwards) {
    run_daemon();
    serve();
    const Browser browser = paired();
    const std::string before = content();
    const auto trial = try_reversed(browser).json()["trial"];
    expect_first_channel(1900);
    EXPECT_EQ(post(browser, "back", {{"trial", trial}}).status, 200);
    expect_first_channel(1100);
    EXPECT_EQ(post(browser, "back", {{"trial", trial}}).status, 409);
    EXPECT_EQ(post(browser, "confirm", {{"trial", trial}}).status, 409);
    EXPECT_EQ(content(), before);
}

TEST_F(Web, ADraftForAFileThatAnotherChangedIsRefusedBeforeAndAfterTheTrial) {
    run_daemon();
    serve();
    const Browser browser = paired();
    EXPECT_EQ(post(browser, "draft", {{"toml", reversed()}}).status, 412)
        << "without a fingerprint";
    const auto trial = try_reversed(browser).json()["trial"];
    expect_first_channel(1900);
    const std::string others = content() + "# by hand\n";
    std::ofstream(file()) << others;
    EXPECT_EQ(post(browser, "confirm", {{"trial", trial}}).status, 412);
    EXPECT_EQ(content(), others);
}

TEST_F(Web, AConfigurationThatDoesNotStartIsMendedFromThePage) {
    write_config("[input.receiver]\nprotocol = \"x\"\n", name() + ".toml");
    serve();
    const Browser browser = paired();
    EXPECT_EQ(listed_state(browser), "absent");
    EXPECT_EQ(browser.get(api("status")).status, 502);
    const BrowserAnswer present = browser.get(api("configuration"));
    const std::string good = main_job(kPatientInput);
    const auto save = [&](const std::string& text) {
        return browser.post(api("save"), {{"toml", text}}, {{"If-Match", present.header("ETag")}});
    };
    EXPECT_EQ(save(present.content).status, 400) << "it has mistakes";
    std::string filled = good;
    for (std::size_t at = filled.find('@'); at != std::string::npos; at = filled.find('@')) {
        filled.replace(at, 1, folder().string() + "/");
    }
    const BrowserAnswer written = save(filled);
    EXPECT_EQ(written.status, 200) << written.content;
    EXPECT_EQ(content(), filled);
    EXPECT_EQ(save(filled).status, 412) << "of the file before";
    run(file());
    EXPECT_EQ(save(filled).status, 409) << "what runs changes on trial only";
}

TEST_F(Web, ABrowserThatMayOnlyLookChangesNothing) {
    run_daemon();
    serve();
    const Browser browser = paired({"--look"});
    EXPECT_EQ(browser.get("/api/me").json()["role"], "look");
    EXPECT_EQ(browser.get(api("status")).status, 200);
    EXPECT_EQ(post(browser, "check", {{"toml", content()}}).status, 200);
    EXPECT_EQ(post(browser, "check", {{"toml", content() + "\n"}}).status, 403)
        << "a text of a stranger may name any file";
    EXPECT_EQ(try_reversed(browser).status, 403);
    for (const std::string what : {"confirm", "back", "save", "record"}) {
        EXPECT_EQ(post(browser, what, {{"trial", 1}}).status, 403) << what;
    }
}

/// Each of them is what a page of another origin, or a name that resolves to this machine, can do.
TEST_F(Web, APageOfAnotherOriginDoesNothing) {
    run_daemon();
    serve();
    const Browser browser = paired();
    const std::string body = json{{"trial", 1}}.dump();
    using Headers = std::map<std::string, std::string>;
    const Headers own{{"Content-Type", "application/json"},
                      {"X-Tribus", "1"},
                      {"Origin", "http://" + browser.host()}};
    const auto status = [&](const std::string& name, const std::string& value) {
        Headers headers = own;
        headers.erase(name);
        if (!value.empty()) {
            headers[name] = value;
        }
        return browser.ask("POST", api("back"), body, headers).status;
    };
    EXPECT_EQ(browser.ask("POST", api("back"), body, own).status, 409) << "the own page may ask";
    EXPECT_EQ(status("Origin", "http://evil.example"), 403);
    EXPECT_EQ(status("Origin", "null"), 403);
    EXPECT_EQ(status("Origin", ""), 403);
    EXPECT_EQ(status("X-Tribus", ""), 403);
    EXPECT_EQ(status("Content-Type", "text/plain"), 415);
    EXPECT_EQ(status("Content-Type", "application/x-www-form-urlencoded"), 415);
    EXPECT_EQ(status("Host", "evil.example"), 421);
    EXPECT_EQ(browser.ask("GET", api("status"), {}, {{"Host", "evil.example"}}).status, 421);
    for (const std::string what : {"status", "stream"}) {
        EXPECT_EQ(browser.ask("GET", api(what), {}, {{"Sec-Fetch-Site", "same-site"}}).status, 403)
            << what << " for a page on another port, which has the cookie";
    }
    EXPECT_EQ(browser.ask("GET", api("status"), {}, {{"Sec-Fetch-Site", "same-origin"}}).status,
              200);
    EXPECT_EQ(browser.ask("GET", api("back"), {}).status, 405) << "no GET changes anything";
    EXPECT_EQ(browser.ask("OPTIONS", api("back"), {}, own).header("Access-Control-Allow-Origin"),
              "");
}

TEST_F(Web, NamesNeverBecomePaths) {
    run_daemon();
    serve();
    const Browser browser = paired();
    for (const std::string& path :
         {std::string("/../state/sessions.json"), std::string("/..%2fstate/sessions.json"),
          std::string("/state/sessions.json"), std::string("/api/../etc/status"),
          std::string("/api/..%2f..%2fetc%2fpasswd/configuration"), std::string("/api//status"),
          api("history/../../state/sessions.json"), api("history/..%2f..%2fsessions"),
          api("../../../etc/passwd"), std::string("/index.html/..")}) {
        EXPECT_EQ(browser.get(path).status, 404) << path;
    }
    EXPECT_EQ(browser.get(api("record/1%0astatus")).status, 404);
}

TEST_F(Web, GarbageEndsItsOwnConnectionOnly) {
    run_daemon();
    serve();
    const Browser browser = paired();
    EventStream stream(browser, port_, api("stream"));
    EXPECT_TRUE(stream.next("status"));
    for (const std::string& bytes :
         {std::string("\0\0\0\0\r\n\r\n", 8), std::string("GET / HTTP/1.1\r\n\r\n"),
          std::string(20'000, 'a'),
          "POST /pair HTTP/1.1\r\nHost: " + browser.host() +
              "\r\nTransfer-Encoding: chunked\r\n\r\n5\r\n",
          std::string("\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03\r\n\r\n", 15)}) {
        const std::string answer = browser.raw(bytes);
        EXPECT_EQ(answer.find("HTTP/1.1 4") == 0 || answer.find("HTTP/1.1 5") == 0, true)
            << answer.substr(0, 60);
        EXPECT_NE(answer.find("Connection: close"), std::string::npos);
    }
    EXPECT_TRUE(stream.next("status"));
    EXPECT_EQ(browser.get(api("status")).status, 200);
}

TEST_F(Web, TheDaemonGoesOnWhenTheServerIsKilled) {
    Program& daemon = run_daemon();
    Program& server = serve();
    const Browser browser = paired();
    EventStream stream(browser, port_, api("stream"));
    EXPECT_TRUE(stream.next("status"));
    server.signal(SIGKILL);
    server.end();
    expect_first_channel(1100);
    expect_clean_end(daemon);
}

}  // namespace
}  // namespace tribus::test::web_test
