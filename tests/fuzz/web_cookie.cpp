#include <algorithm>
#include <cctype>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "app/web/http/access.h"
#include "app/web/http/cookie.h"
#include "app/web/http/http.h"
#include "tests/fuzz/fuzz.h"

namespace tribus::fuzz::web_cookie_target {
namespace {

constexpr std::string_view kName = "tribus_8480";

std::string in_small_letters(std::string_view text) {
    std::string small(text);
    std::ranges::transform(small, small.begin(), [](unsigned char c) { return std::tolower(c); });
    return small;
}

void read_cookies(std::string_view cookies) {
    const std::string_view value = web::cookie_value(cookies, kName);
    require(value.find(';') == std::string_view::npos, "a cookie ends at its semicolon");
    require(value.empty() || cookies.find(std::string(kName) + "=" + std::string(value)) !=
                                 std::string_view::npos,
            "a cookie's value stands behind its name");
    const std::string hash = web::hash_of_cookie(value);
    require(hash.empty() == (value.size() != 64), "a cookie has 64 signs");
    require(std::ranges::all_of(hash, [](unsigned char c) { return std::isxdigit(c) != 0; }),
            "a hash is hexadecimal");
    const std::string before = "a=b; " + std::string(kName) + "=first; " + std::string(cookies);
    require(web::cookie_value(before, kName) == "first", "the first cookie of a name counts");
}

void read_host(std::string_view host) {
    const std::vector<std::string> names = web::own_names("Board", {"Mine.Example"});
    if (!web::is_own_host(host, names)) {
        return;
    }
    const std::string small = in_small_letters(host);
    const bool by_name = std::ranges::any_of(
        std::vector<std::string>{"board", "board.local", "mine.example", "localhost"},
        [&](const std::string& name) { return small == name || small.starts_with(name + ":"); });
    require(by_name || small.find_first_not_of("0123456789abcdef.:[]") == std::string::npos,
            "a host is one of the own names, or an address");
}

}  // namespace

/// The headers Cookie and Host with any content: one line a header.
FUZZ_TARGET(web_cookie) {
    const std::string_view all(reinterpret_cast<const char*>(data), size);
    const std::size_t line_end = std::min(all.find('\n'), all.size());
    read_cookies(all.substr(0, line_end));
    read_host(all.substr(std::min(line_end + 1, all.size())));
    return 0;
}

}  // namespace tribus::fuzz::web_cookie_target
