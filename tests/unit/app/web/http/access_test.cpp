#include "app/web/http/access.h"

#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace tribus::test::access_test {
namespace {

using namespace web;

TEST(Access, TakesAddressesLocalhostAndTheNamesOfTheMachine) {
    const auto names = own_names("Boat", {"boat.example.org"});
    for (const auto* host : {"127.0.0.1", "127.0.0.1:8480", "192.168.1.7:80", "[::1]:8480", "[::1]",
                             "[fe80::1]:8480", "localhost", "LOCALHOST:8480", "boat", "boat:8480",
                             "boat.local", "BOAT.local:8480", "boat.example.org:443"}) {
        EXPECT_TRUE(is_own_host(host, names)) << host;
    }
}

TEST(Access, RefusesOtherNamesThatMayResolveToThisMachine) {
    const auto names = own_names("boat", {});
    for (const auto* host :
         {"evil.example", "boat.evil.example", "boat.local.evil.example", "127.0.0.1.evil.example",
          "localhost.evil.example", "", ":8480", "boat:", "boat:x", "boat:848000", "[::1", "[::1]x",
          "[evil]", "boat@evil", "evil/boat", "0x7f000001", "2130706433", "boat ", "127.1"}) {
        EXPECT_FALSE(is_own_host(host, names)) << host;
    }
    EXPECT_FALSE(is_own_host(std::string_view("127.0.0.1\0.evil", 15), names));
}

HttpRequest change() {
    HttpRequest request;
    request.method = "POST";
    request.host = "boat.local:8480";
    request.origin = "http://boat.local:8480";
    request.content_type = "application/json";
    request.marked = true;
    return request;
}

TEST(Access, AChangeFromTheOwnPageMayPassAlsoBehindAProxyWithTls) {
    EXPECT_FALSE(why_not_from_own_page(change()));
    HttpRequest behind_proxy = change();
    behind_proxy.origin = "https://boat.local:8480";
    behind_proxy.content_type = "application/json; charset=utf-8";
    EXPECT_FALSE(why_not_from_own_page(behind_proxy));
}

TEST(Access, AChangeFromElsewhereIsRefused) {
    const auto status = [](auto alter) {
        HttpRequest request = change();
        alter(request);
        const auto why = why_not_from_own_page(request);
        return why ? why->status : 0;
    };
    EXPECT_EQ(status([](auto& r) { r.method = "GET"; }), 405);
    EXPECT_EQ(status([](auto& r) { r.method = "PUT"; }), 405);
    for (const auto* type : {"", "text/plain", "application/x-www-form-urlencoded",
                             "multipart/form-data", "application/jsonx"}) {
        EXPECT_EQ(status([&](auto& r) { r.content_type = type; }), 415) << type;
    }
    EXPECT_EQ(status([](auto& r) { r.marked = false; }), 403);
    EXPECT_EQ(status([](auto& r) { r.origin.reset(); }), 403);
    for (const auto* origin :
         {"null", "", "http://evil", "http://boat.local", "http://boat.local:8481",
          "http://boat.local:8480.evil", "http://evil/boat.local:8480", "boat.local:8480"}) {
        EXPECT_EQ(status([&](auto& r) { r.origin = origin; }), 403) << origin;
    }
}

/// The values are those of W3C Fetch Metadata; a page on another port of the host is `same-site`.
TEST(Access, OnlyTheOwnPageAndTheAddressBarMayAsk) {
    const auto another_page = [](const std::string& site) {
        HttpRequest request;
        request.fetch_site = site;
        return is_asked_by_another_page(request);
    };
    EXPECT_FALSE(another_page("")) << "an older browser, or plain HTTP";
    EXPECT_FALSE(another_page("same-origin"));
    EXPECT_FALSE(another_page("none")) << "typed by the person";
    EXPECT_TRUE(another_page("same-site"));
    EXPECT_TRUE(another_page("cross-site"));
    EXPECT_TRUE(another_page("Same-Origin")) << "no browser writes it so";
}

}  // namespace
}  // namespace tribus::test::access_test
