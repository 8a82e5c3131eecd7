#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>
#include <tuple>
#include <variant>

#include "app/web/http/access.h"
#include "app/web/http/http.h"
#include "app/web/server/site.h"
#include "core/utf8.h"
#include "tests/fuzz/fuzz.h"

namespace tribus::fuzz::web_request_target {
namespace {

using web::HttpRefusal;
using web::HttpRequest;
using web::MoreBytes;
using Parsed = std::variant<MoreBytes, HttpRequest, HttpRefusal>;

bool same_request(const HttpRequest& one, const HttpRequest& other) {
    const auto texts = [](const HttpRequest& of) {
        return std::tie(of.method, of.path, of.query, of.host, of.origin, of.fetch_site, of.cookie,
                        of.content_type, of.if_match, of.body);
    };
    return texts(one) == texts(other) && one.marked == other.marked &&
           one.takes_gzip == other.takes_gzip && one.keeps_open == other.keeps_open &&
           one.bytes == other.bytes;
}

bool same(const Parsed& one, const Parsed& other) {
    if (one.index() != other.index()) {
        return false;
    }
    if (const auto* request = std::get_if<HttpRequest>(&one)) {
        return same_request(*request, std::get<HttpRequest>(other));
    }
    const auto* refusal = std::get_if<HttpRefusal>(&one);
    return refusal == nullptr || (refusal->status == std::get<HttpRefusal>(other).status &&
                                  refusal->why == std::get<HttpRefusal>(other).why);
}

/// Looks after each byte. Long requests are looked at in steps, or a run would take too long.
void arrive_in_pieces(std::string_view received, const Parsed& whole) {
    constexpr std::size_t kMostLooks = 600;
    const std::size_t step = 1 + received.size() / kMostLooks;
    std::size_t least = 0;
    for (std::size_t size = 0; size < received.size(); size += step) {
        const Parsed part = web::parse_http(received.substr(0, size));
        if (const auto* more = std::get_if<MoreBytes>(&part)) {
            require(more->least > size, "more bytes are more than there are");
            least = std::max(least, more->least);
            continue;
        }
        require(size >= least, "so many bytes were needed");
        require(same(part, whole), "a request in pieces is the same as in one");
        return;
    }
}

void look_at(const HttpRequest& request, std::size_t received) {
    require(request.bytes <= received, "no more is taken than has come");
    require(request.body.size() < request.bytes, "the content is a part of the request");
    require(request.body.size() <= web::kLongestBody, "no content is longer than the limit");
    require(request.path.starts_with('/'), "a path begins with /");
    require(request.path.find('?') == std::string::npos, "a path has no query");
    if (!web::why_not_from_own_page(request)) {
        require(request.method == "POST" && request.marked && request.origin &&
                    request.origin->size() > request.host.size(),
                "what may change something is marked and says from which page it comes");
    }
    for (const std::string* text :
         {&request.method, &request.path, &request.query, &request.host, &request.cookie}) {
        require(text->find_first_of(std::string_view("\r\n\0", 3)) == std::string::npos,
                "a part stands in one line, without zero bytes");
    }
    for (const web::Route& route : web::Site::known_routes()) {
        if (const auto names = web::names_in(route, request.path)) {
            require(std::ranges::all_of(*names, is_utf8), "a name in a path is a text");
            require(names->front().empty() == (route.path.find('*') == std::string_view::npos),
                    "no name is empty");
        }
    }
}

}  // namespace

/// Bytes that a browser, or something that pretends to be one, sends: one or more requests of
/// HTTP/1.1, each of which is taken, refused or waited for, however it is cut in pieces.
FUZZ_TARGET(web_request) {
    std::string_view rest(reinterpret_cast<const char*>(data), size);
    while (!rest.empty()) {
        const auto parsed = web::parse_http(rest);
        arrive_in_pieces(rest, parsed);
        const auto* request = std::get_if<web::HttpRequest>(&parsed);
        if (request == nullptr) {
            break;
        }
        look_at(*request, rest.size());
        rest.remove_prefix(request->bytes);
    }
    return 0;
}

}  // namespace tribus::fuzz::web_request_target
