#include <optional>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "app/web/server/routes.h"
#include "app/web/server/site.h"
#include "tests/support/manual_routes.h"

namespace tribus::web::routes_test {
namespace {

using Names = std::vector<std::string>;

std::optional<Names> names_of(std::string_view pattern, std::string_view path) {
    const auto names = names_in({"GET", pattern, Access::looks}, path);
    return names ? std::optional(Names{names->begin(), names->end()}) : std::nullopt;
}

TEST(PathNames, StandForOneWholePart) {
    EXPECT_EQ(names_of("/api/*/record/*", "/api/boat/record/7"), (Names{"boat", "7"}));
    EXPECT_EQ(names_of("/api/*/status", "/api/boat/status"), (Names{"boat", ""}));
    for (const char* const path : {"/api/boat/record", "/api/boat/record/", "/api/boat/record/7/",
                                   "/api//record/7", "/api/boat/record/7/8", "/api/boat/records/7",
                                   "api/boat/record/7", "/API/boat/record/7", ""}) {
        EXPECT_EQ(names_of("/api/*/record/*", path), std::nullopt) << path;
    }
}

TEST(PathNames, AreDecoded) {
    EXPECT_EQ(names_of("/api/*/status", "/api/my%20boat/status"), (Names{"my boat", ""}));
    EXPECT_EQ(names_of("/api/*/status", "/api/f%C3%a4hre/status"), (Names{"fähre", ""}));
    EXPECT_EQ(names_of("/api/*/status", "/api/a%2Fb/status"), (Names{"a/b", ""}));
    EXPECT_EQ(names_of("/api/*/status", "/api/%25/status"), (Names{"%", ""}));
    EXPECT_EQ(names_of("/api/*/status", "/api/boat/%73tatus"), std::nullopt) << "only names are";
}

TEST(PathNames, ThatAreNoTextAreOfNoRoute) {
    for (const char* const name : {"%", "%4", "%4g", "%g4", "%-1", "%+1", "% 1", "%0x", "%FF",
                                   "%C3", "%C3%28", "\xC3", "%ED%A0%80"}) {
        EXPECT_EQ(names_of("/api/*/status", "/api/" + std::string(name) + "/status"), std::nullopt)
            << name;
    }
}

/// A request as the page sends it.
HttpRequest own_request(const Route& route) {
    HttpRequest request;
    request.method = route.method;
    request.path = route.path;
    request.host = "board";
    request.origin = "http://board";
    request.content_type = "application/json";
    request.marked = true;
    return request;
}

int status_for(const Route& route, const HttpRequest& request, std::optional<Role> role) {
    const auto why = why_not(route, request, role);
    return why ? why->status : 200;
}

TEST(Routes, AreForTheRoleThatTheySay) {
    for (const Route& route : Site::known_routes()) {
        const HttpRequest request = own_request(route);
        const bool anybody = route.access == Access::anybody;
        EXPECT_EQ(status_for(route, request, std::nullopt), anybody ? 200 : 401) << route.path;
        EXPECT_EQ(status_for(route, request, Role::look),
                  route.access == Access::changes ? 403 : 200)
            << route.path;
        EXPECT_EQ(status_for(route, request, Role::change), 200) << route.path;
    }
}

TEST(Routes, ThatPostAreForThePageItselfOnly) {
    for (const Route& route : Site::known_routes()) {
        const int refused = route.method == "POST" ? 403 : 200;
        HttpRequest request = own_request(route);
        request.origin = "http://evil.example";
        EXPECT_EQ(status_for(route, request, Role::change), refused) << route.path;
        request.origin.reset();
        EXPECT_EQ(status_for(route, request, Role::change), refused) << route.path;
        request = own_request(route);
        request.marked = false;
        EXPECT_EQ(status_for(route, request, Role::change), refused) << route.path;
    }
}

TEST(Routes, ThatGetChangeNothing) {
    for (const Route& route : Site::known_routes()) {
        EXPECT_TRUE(route.method == "POST" || route.method == "GET") << route.path;
        EXPECT_TRUE(route.method == "POST" || route.access != Access::changes) << route.path;
    }
}

std::string word_of(Access access) {
    return access == Access::anybody ? "anybody" : access == Access::looks ? "looks" : "changes";
}

TEST(Routes, StandInTheManualWithWhoMayAskThem) {
    const std::regex name("/(N|ID|NUMBER|ID.tar)(?=/|$)");
    std::set<std::string> told;
    for (const auto& [method, path, who] : test::manual_routes()) {
        if (path != "/") {
            told.insert(method + " " + std::regex_replace(path, name, "/*") + " " + who);
        }
    }
    std::set<std::string> known;
    for (const Route& route : Site::known_routes()) {
        known.insert(std::string(route.method) + " " + std::string(route.path) + " " +
                     word_of(route.access));
    }
    EXPECT_EQ(told, known);
}

}  // namespace
}  // namespace tribus::web::routes_test
