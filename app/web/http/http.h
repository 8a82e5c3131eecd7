#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

/// The part of HTTP/1.1 that the page needs (RFC 9112). Boost.Beast parses; what it lets pass and a
/// proxy might understand otherwise is refused first: any Transfer-Encoding, not exactly one Host,
/// folded lines. Pure and reentrant.
namespace tribus::web {

struct HttpRequest {
    std::string method;
    std::string path;   ///< begins with '/'
    std::string query;  ///< behind '?', without it
    std::string host;
    std::optional<std::string> origin;
    std::string fetch_site;  ///< Sec-Fetch-Site (W3C Fetch Metadata); browsers may leave it out
    std::string cookie;
    std::string content_type;
    std::string if_match;
    std::string forwarded_for;  ///< who asks, as the nearest proxy says (X-Forwarded-For)
    std::string body;
    bool marked = false;  ///< has `X-Tribus: 1`, which no form of another page can send
    bool takes_gzip = false;
    bool keeps_open = true;
    std::size_t bytes = 0;  ///< of the whole request
};

/// The connection must be closed behind the answer.
struct HttpRefusal {
    int status = 400;
    std::string why;  ///< a sentence
};

/// So many bytes, from the beginning of the request, are needed before another look.
struct MoreBytes {
    std::size_t least = 0;
};

inline constexpr std::size_t kLongestHead = 8 * 1024;
/// More than 64 outputs with a map each need; to judge a text of this length takes a fraction of a
/// second, in which the server has nothing for others.
inline constexpr std::size_t kLongestBody = 64 * 1024;

/// Reads the request with which `received` begins.
std::variant<MoreBytes, HttpRequest, HttpRefusal> parse_http(std::string_view received);

/// The value of that cookie, or empty.
std::string_view cookie_value(std::string_view cookies, std::string_view name);

/// An answer. `http_text` adds the headers that every answer has: no other page may frame or read
/// it, and a page's scripts come from here only.
struct HttpAnswer {
    int status = 200;
    std::string_view type = "application/json";
    std::string content{};
    /// Each with its end of line.
    std::string headers{};
    /// Names of files of the page change with their content.
    bool cached = false;
    bool gzip = false;
    /// The content goes on until the connection ends.
    bool endless = false;
    bool keeps_open = true;
    /// The rest, which follows piece by piece as of SocketClient::Source, and its length.
    std::function<std::optional<std::string>()> source{};
    std::uint64_t source_bytes = 0;
};
std::string http_text(const HttpAnswer& answer);

}  // namespace tribus::web
