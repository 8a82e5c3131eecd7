#include "app/web/http/http.h"

#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <gtest/gtest.h>

namespace tribus::test::http_test {
namespace {

using namespace web;

const std::string kLine = "POST /api/boat/check?a=1 HTTP/1.1\r\n";
const std::string kHost = "Host: board.local:8480\r\n";
const std::string kEnd = "\r\n";

/// 0 if it is a request, -1 if more bytes are needed, else the status of the refusal.
int status_of(const std::string& received) {
    const auto parsed = parse_http(received);
    const auto* refusal = std::get_if<HttpRefusal>(&parsed);
    return refusal != nullptr                            ? refusal->status
           : std::holds_alternative<HttpRequest>(parsed) ? 0
                                                         : -1;
}

TEST(Http, ReadsWhatThePageNeeds) {
    const std::string text =
        kLine + kHost +
        "Origin: http://board.local:8480\r\nCookie: a=1; tribus_8480=xyz\r\n"
        "Content-Type: application/json\r\nIf-Match: \"7\"\r\nX-Tribus: 1\r\n"
        "Sec-Fetch-Site: same-site\r\nAccept-Encoding: br, gzip\r\nContent-Length: 2\r\n\r\n{}";
    const auto parsed = parse_http(text + "GET / HTTP/1.1\r\n");
    const auto* request = std::get_if<HttpRequest>(&parsed);
    ASSERT_NE(request, nullptr);
    EXPECT_EQ(request->method, "POST");
    EXPECT_EQ(request->path, "/api/boat/check");
    EXPECT_EQ(request->query, "a=1");
    EXPECT_EQ(request->host, "board.local:8480");
    EXPECT_EQ(request->origin, "http://board.local:8480");
    EXPECT_EQ(request->fetch_site, "same-site");
    EXPECT_EQ(cookie_value(request->cookie, "tribus_8480"), "xyz");
    EXPECT_EQ(request->content_type, "application/json");
    EXPECT_EQ(request->if_match, "\"7\"");
    EXPECT_TRUE(request->marked);
    EXPECT_TRUE(request->takes_gzip);
    EXPECT_TRUE(request->keeps_open);
    EXPECT_EQ(request->body, "{}");
    EXPECT_EQ(request->bytes, text.size()) << "what follows is not of it";
}

TEST(Http, NoPartOfARequestIsARequestOrRefused) {
    const std::string text = kLine + kHost + "Content-Length: 5\r\n\r\nabcde";
    for (std::size_t cut = 0; cut < text.size(); ++cut) {
        EXPECT_EQ(status_of(text.substr(0, cut)), -1) << cut;
    }
    EXPECT_EQ(status_of(text), 0);
}

/// Each of them was taken by some server for something that another one understands otherwise.
const std::vector<std::pair<std::string, int>>& attacks() {
    static const std::vector<std::pair<std::string, int>> all{
        {kLine + kHost + "Transfer-Encoding: chunked\r\n\r\n0\r\n\r\n", 501},
        {kLine + kHost + "Transfer-Encoding: chunked, gzip\r\n\r\n", 501},
        {kLine + kHost + "Transfer-Encoding: gzip\r\n\r\n", 501},
        {kLine + kHost + "Content-Length: 0\r\nTransfer-Encoding: chunked\r\n\r\n", 400},
        {kLine + kHost + "Content-Length: 3\r\nTransfer-Encoding: chunked\r\n\r\nabc", 400},
        {kLine + kHost + "Content-Length: 3\r\nContent-Length: 4\r\n\r\nabcd", 400},
        {kLine + kHost + "Content-Length: -1\r\n\r\n", 400},
        {kLine + kHost + "Content-Length: +4\r\n\r\nabcd", 400},
        {kLine + kHost + "Content-Length: 4 4\r\n\r\nabcd", 400},
        {kLine + kHost + "Content-Length: 99999999999999999999\r\n\r\n", 400},
        {kLine + kHost + "Content-Length: 262145\r\n\r\n", 413},
        {kLine + kHost + "Host: other\r\n\r\n", 400},
        {kLine + "\r\n", 400},
        {kLine + kHost + "Cookie: a\r\nCookie: b\r\n\r\n", 400},
        {kLine + kHost + "Origin: a\r\nOrigin: b\r\n\r\n", 400},
        {kLine + kHost + "A: b\r\n folded\r\n\r\n", 400},
        {kLine + kHost + "A: b\r\n\tfolded\r\n\r\n", 400},
        {kLine + kHost + "A : b\r\n\r\n", 400},
        {kLine + kHost + std::string("A: b\0c\r\n\r\n", 10), 400},
        {"POST / HTTP/1.1\nHost: a\n\n\r\n\r\n", 400},
        {"GET / HTTP/1.0\r\n" + kHost + kEnd, 505},
        {"GET / HTTP/2.0\r\n" + kHost + kEnd, 400},
        {"GET http://other/ HTTP/1.1\r\n" + kHost + kEnd, 400},
        {"GET * HTTP/1.1\r\n" + kHost + kEnd, 400},
        {" GET / HTTP/1.1\r\n" + kHost + kEnd, 400},
        {"GET  / HTTP/1.1\r\n" + kHost + kEnd, 400},
        {"\r\n\r\n", 400},
        {std::string(kLongestHead, 'a'), 431},
        {kLine + kHost + "A: " + std::string(kLongestHead, 'a') + "\r\n\r\n", 431},
    };
    return all;
}

TEST(Http, RefusesWhatAnotherProgramMightReadOtherwise) {
    for (const auto& [text, status] : attacks()) {
        EXPECT_EQ(status_of(text), status) << text.substr(0, 120);
    }
}

TEST(Http, NoPartOfAnAttackIsTakenForARequest) {
    for (const auto& [text, status] : attacks()) {
        const std::size_t step = text.size() > 4096 ? 97 : 1;
        for (std::size_t cut = 0; cut < text.size(); cut += step) {
            EXPECT_NE(status_of(text.substr(0, cut)), 0) << text.substr(0, cut).substr(0, 120);
        }
    }
}

TEST(Http, TheLongestContentIsTaken) {
    const std::string text =
        kLine + kHost + "Content-Length: " + std::to_string(kLongestBody) + "\r\n\r\n";
    EXPECT_EQ(status_of(text + std::string(kLongestBody, 'x')), 0);
}

TEST(Http, FindsACookieByItsWholeName) {
    EXPECT_EQ(cookie_value("a=1; b=2", "b"), "2");
    EXPECT_EQ(cookie_value("ab=1", "b"), "");
    EXPECT_EQ(cookie_value("b=1; b=2", "b"), "1");
    EXPECT_EQ(cookie_value("", "b"), "");
    EXPECT_EQ(cookie_value(";;=; b", "b"), "");
}

TEST(Http, EachAnswerForbidsFramesScriptsOfOthersAndSniffing) {
    const std::string text = http_text({.status = 404, .content = "x"});
    EXPECT_EQ(text.find("HTTP/1.1 404 Not Found\r\n"), 0U);
    for (const auto* header :
         {"default-src 'none'", "frame-ancestors 'none'", "X-Content-Type-Options: nosniff",
          "Referrer-Policy: no-referrer", "Cache-Control: no-store", "Content-Length: 1\r\n"}) {
        EXPECT_NE(text.find(header), std::string::npos) << header;
    }
    EXPECT_EQ(text.find("Access-Control"), std::string::npos);
    EXPECT_TRUE(text.ends_with("\r\n\r\nx"));
}

}  // namespace
}  // namespace tribus::test::http_test
