#include <chrono>
#include <csignal>
#include <list>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/web/http/http.h"
#include "tests/loopback/web.h"

/// Browsers that take too much, and daemons that come and go, before the page's server.
namespace tribus::test::web_limits_test {
namespace {

using WebLimits = Web;
using web::kLongestBody;

/// The server has 16 places.
TEST_F(WebLimits, ThirtyConnectionsThatAskNothingKeepNobodyOut) {
    run_daemon();
    serve();
    const Browser browser = paired();
    EventStream stream(browser, port_, api("stream"));
    EXPECT_TRUE(stream.next("status"));
    std::list<OpenConnection> idle;
    for (int i = 0; i < 30; ++i) {
        idle.emplace_back(port_, "GET / HTTP/1.1\r\nX-Slow: ");
    }
    EXPECT_EQ(browser.get(api("status")).status, 200);
    EXPECT_TRUE(stream.next("status"));
}

TEST_F(WebLimits, StreamsFromOneAddressKeepNobodyOutWhoComesFromAnother) {
    run_daemon();
    serve();
    std::list<Browser> greedy;
    std::list<EventStream> streams;
    for (int i = 0; i < 16; ++i) {
        if (i % 4 == 0) {
            greedy.push_back(paired());
        }
        streams.emplace_back(greedy.back(), port_, api("stream"));
        EXPECT_TRUE(streams.back().next("status")) << i;
    }
    EXPECT_EQ(Browser(port_).get("/api/me").status, 0) << "all places are taken";
    EXPECT_EQ(Browser(port_, "127.0.0.2").get("/api/me").status, 200);
}

/// What the kernel holds for it is bounded; the others get each status.
TEST_F(WebLimits, AStreamThatNobodyReadsHoldsUpNoOther) {
    run_daemon();
    serve();
    const Browser browser = paired();
    const std::string head = "GET " + api("stream") +
                             "?rate=20 HTTP/1.1\r\nHost: " + browser.host() +
                             "\r\nCookie: " + browser.cookie() + "\r\n\r\n";
    const OpenConnection lazy(port_, head);
    EventStream stream(browser, port_, api("stream") + "?rate=20");
    for (int i = 0; i < 30; ++i) {
        ASSERT_TRUE(stream.next("status")) << i;
        repeater_.send_if_due();
    }
}

TEST_F(WebLimits, ADraftThatIsTooLongIsRefused) {
    run_daemon();
    serve();
    const Browser browser = paired();
    EXPECT_EQ(post(browser, "check", {{"toml", std::string(60'000, '#')}}).status, 200);
    EXPECT_EQ(post(browser, "check", {{"toml", std::string(70'000, '#')}}).status, 413);
}

/// It reads why, and the page of somebody else goes on.
TEST_F(WebLimits, WhoSendsFourMegabytesReadsThatTheyAreTooMany) {
    run_daemon();
    serve();
    const Browser browser = paired();
    EventStream stream(browser, port_, api("stream") + "?rate=20");
    ASSERT_TRUE(stream.next("status"));
    const std::string body(4'000'000, ' ');
    for (const std::string& cookie : {browser.cookie(), std::string("none=1")}) {
        const std::string answer =
            browser.raw("POST " + api("check") + " HTTP/1.1\r\nHost: " + browser.host() +
                        "\r\nCookie: " + cookie +
                        "\r\nContent-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body);
        EXPECT_EQ(answer.find("HTTP/1.1 413"), 0U) << answer;
        EXPECT_NE(answer.find("longer than 64 KiB"), std::string::npos) << answer;
    }
    repeater_.send_if_due();
    EXPECT_TRUE(stream.next("status"));
}

/// A copy of a deep tree needs a stack as deep, before anybody is known.
TEST_F(WebLimits, DeepJsonIsRefusedAndEndsNoServer) {
    run_daemon();
    serve();
    const Browser browser = paired();
    const std::size_t deep = kLongestBody / 2 - 100;
    const std::string nested = std::string(deep, '[') + std::string(deep, ']');
    for (const std::string& body : {nested, R"({"toml": "a", "code": )" + nested + "}"}) {
        for (const std::string& path : {std::string("/pair"), api("check"), api("draft")}) {
            EXPECT_EQ(browser.post_text(path, body).status, 400) << path;
        }
    }
    EXPECT_EQ(browser.get(api("status")).status, 200);
}

/// RFC 9112, 11.2: the rest of a request that was refused would be taken for the next one.
TEST_F(WebLimits, AfterARefusedRequestNothingIsAnswered) {
    serve();
    const Browser browser(port_);
    const std::string host = "Host: " + browser.host() + "\r\n";
    const std::string next = "GET /api/me HTTP/1.1\r\n" + host + "\r\n";
    for (const std::string& refused :
         {"POST /pair HTTP/1.1\r\n" + host + "Transfer-Encoding: chunked, gzip\r\n\r\n",
          "GET /api/me HTTP/1.1\r\n" + host + "Host: evil.example\r\n\r\n",
          "GET /api/me HTTP/1.1\r\n" + host + "X: a\r\n b\r\n\r\n",
          std::string("GET /api/me HTTP/1.1\r\nHost: evil.example\r\n\r\n")}) {
        for (const std::string& answer :
             {browser.raw(refused + next), browser.raw(refused, next)}) {
            EXPECT_EQ(answer.find("HTTP/1.1 200"), std::string::npos) << refused << answer;
            EXPECT_EQ(answer.find("HTTP/1.1", 1), std::string::npos) << refused << answer;
        }
    }
}

TEST_F(WebLimits, RequestsThatComeTogetherAreAllAnswered) {
    run_daemon();
    serve();
    const Browser browser = paired();
    const std::string head =
        " HTTP/1.1\r\nHost: " + browser.host() + "\r\nCookie: " + browser.cookie();
    const std::string answers =
        browser.raw("GET /api/me" + head + "\r\n\r\nGET " + api("status") + head +
                    "\r\n\r\nGET /api/daemons" + head + "\r\nConnection: close\r\n\r\n");
    const std::size_t me = answers.find("\"role\"");
    const std::size_t status = answers.find("\"type\":\"status\"");
    const std::size_t daemons = answers.find("\"daemons\":[");
    EXPECT_TRUE(me < status && status < daemons && daemons != std::string::npos) << answers;
    EXPECT_NE(answers.find("Connection: close"), std::string::npos) << "the last one ends it";
}

TEST_F(WebLimits, ADaemonThatStartsLaterOrAgainIsSeenByTheOpenPage) {
    const std::string config = write_config(main_job(kPatientInput), name() + ".toml");
    serve();
    const Browser browser = paired();
    EventStream stream(browser, port_, api("stream"));
    EXPECT_TRUE(stream.next("gone"));
    Program& first = run(config);
    EXPECT_TRUE(stream.next("status"));
    expect_clean_end(first);
    EXPECT_TRUE(stream.next("gone"));
    run(config);
    EXPECT_TRUE(stream.next("status"));
}

}  // namespace
}  // namespace tribus::test::web_limits_test
