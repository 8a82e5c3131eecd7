#include "app/web/http/http.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <utility>

#include <fmt/format.h>
#include <boost/asio/buffer.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/string_body.hpp>

namespace tribus::web {
namespace {

namespace http = boost::beast::http;
using Message = http::request<http::string_body>;

constexpr const char* kTooLong = "the content is longer than 64 KiB";
constexpr std::string_view kHeadEnd = "\r\n\r\n";

std::string text_of(boost::beast::string_view text) {
    return {text.data(), text.size()};
}

/// A line that begins with a blank goes on the one before.
bool has_folded_line(std::string_view head) {
    for (std::size_t at = head.find("\r\n"); at != std::string_view::npos;
         at = head.find("\r\n", at + 2)) {
        const char next = at + 2 < head.size() ? head[at + 2] : 'x';
        if (next == ' ' || next == '\t') {
            return true;
        }
    }
    return false;
}

std::size_t count_of(const Message& message, http::field name) {
    const auto [first, last] = message.equal_range(name);
    return static_cast<std::size_t>(std::distance(first, last));
}

HttpRefusal refusal_of(boost::beast::error_code error) {
    if (error == http::error::body_limit) {
        return {413, kTooLong};
    }
    if (error == http::error::header_limit) {
        return {431, "the head is longer than 8 KiB"};
    }
    return {400, "that is no request of HTTP/1.1"};
}

std::optional<HttpRefusal> mistake_in(const Message& message) {
    if (message.version() != 11) {
        return HttpRefusal{505, "only HTTP/1.1"};
    }
    if (count_of(message, http::field::transfer_encoding) != 0) {
        return HttpRefusal{501, "content is taken with its length only"};
    }
    if (count_of(message, http::field::host) != 1) {
        return HttpRefusal{400, "exactly one Host is needed"};
    }
    for (const http::field once : {http::field::origin, http::field::cookie,
                                   http::field::content_type, http::field::content_length}) {
        if (count_of(message, once) > 1) {
            return HttpRefusal{400, "a header that may stand once stands twice"};
        }
    }
    const auto target = message.target();
    if (target.empty() || target.front() != '/') {
        return HttpRefusal{400, "the target must begin with /"};
    }
    return std::nullopt;
}

HttpRequest request_of(Message&& message, std::size_t bytes) {
    HttpRequest request;
    request.method = text_of(message.method_string());
    const std::string target = text_of(message.target());
    const std::size_t question = target.find('?');
    request.path = target.substr(0, question);
    request.query = question == std::string::npos ? std::string() : target.substr(question + 1);
    request.host = text_of(message[http::field::host]);
    if (count_of(message, http::field::origin) == 1) {
        request.origin = text_of(message[http::field::origin]);
    }
    request.fetch_site = text_of(message["Sec-Fetch-Site"]);
    request.cookie = text_of(message[http::field::cookie]);
    request.content_type = text_of(message[http::field::content_type]);
    request.if_match = text_of(message[http::field::if_match]);
    // Each proxy adds whom it saw, and the nearest one is last.
    const std::string forwarded = text_of(message["X-Forwarded-For"]);
    const std::size_t last = forwarded.find_last_of(", ");
    request.forwarded_for = last == std::string::npos ? forwarded : forwarded.substr(last + 1);
    request.marked = message["X-Tribus"] == "1";
    request.takes_gzip =
        text_of(message[http::field::accept_encoding]).find("gzip") != std::string::npos;
    request.keeps_open = message.keep_alive();
    request.body = std::move(message.body());
    request.bytes = bytes;
    return request;
}

std::string_view reason_of(int status) {
    const auto reason = http::obsolete_reason(static_cast<http::status>(status));
    return {reason.data(), reason.size()};
}

constexpr std::string_view kAlways =
    "Content-Security-Policy: default-src 'none'; script-src 'self'; style-src 'self'; "
    "connect-src 'self'; img-src 'self' data:; frame-ancestors 'none'; base-uri 'none'; "
    "form-action 'self'\r\n"
    "X-Content-Type-Options: nosniff\r\n"
    "Referrer-Policy: no-referrer\r\n"
    "Cross-Origin-Resource-Policy: same-origin\r\n";

}  // namespace

std::variant<MoreBytes, HttpRequest, HttpRefusal> parse_http(std::string_view received) {
    const std::size_t head = received.substr(0, kLongestHead).find(kHeadEnd);
    if (head == std::string_view::npos) {
        if (received.size() >= kLongestHead) {
            return HttpRefusal{431, "the head is longer than 8 KiB"};
        }
        return MoreBytes{received.size() + 1};
    }
    if (has_folded_line(received.substr(0, head))) {
        return HttpRefusal{400, "a header must stand in one line"};
    }
    http::request_parser<http::string_body> parser;
    parser.header_limit(kLongestHead);
    parser.body_limit(kLongestBody);
    boost::beast::error_code error;
    std::size_t taken =
        parser.put(boost::asio::buffer(received.data(), head + kHeadEnd.size()), error);
    if (error && error != http::error::need_more) {
        return refusal_of(error);
    }
    if (!parser.is_header_done()) {
        return HttpRefusal{400, "that is no request of HTTP/1.1"};
    }
    if (auto mistake = mistake_in(parser.get())) {
        return *std::move(mistake);
    }
    const std::size_t length = static_cast<std::size_t>(parser.content_length().value_or(0));
    const std::size_t whole = head + kHeadEnd.size() + length;
    if (length > kLongestBody) {
        return HttpRefusal{413, kTooLong};
    }
    if (received.size() < whole) {
        return MoreBytes{whole};
    }
    if (!parser.is_done()) {
        taken += parser.put(boost::asio::buffer(received.data() + taken, length), error);
    }
    if (!parser.is_done() || taken != whole) {
        return HttpRefusal{400, "that is no request of HTTP/1.1"};
    }
    return request_of(parser.release(), whole);
}

std::string_view cookie_value(std::string_view cookies, std::string_view name) {
    while (!cookies.empty()) {
        const std::size_t end = cookies.find(';');
        std::string_view one = cookies.substr(0, end);
        one.remove_prefix(std::min(one.find_first_not_of(' '), one.size()));
        const std::size_t equals = one.find('=');
        if (equals != std::string_view::npos && one.substr(0, equals) == name) {
            return one.substr(equals + 1);
        }
        cookies.remove_prefix(end == std::string_view::npos ? cookies.size() : end + 1);
    }
    return {};
}

std::string http_text(const HttpAnswer& answer) {
    std::string text =
        fmt::format("HTTP/1.1 {} {}\r\nContent-Type: {}\r\n{}Cache-Control: {}\r\n{}{}{}",
                    answer.status, reason_of(answer.status), answer.type, kAlways,
                    answer.cached ? "public, max-age=31536000, immutable" : "no-store",
                    answer.headers, answer.gzip ? "Content-Encoding: gzip\r\n" : "",
                    answer.keeps_open && !answer.endless ? "" : "Connection: close\r\n");
    if (!answer.endless) {
        text += fmt::format("Content-Length: {}\r\n", answer.content.size() + answer.source_bytes);
    }
    return text + "\r\n" + answer.content;
}

}  // namespace tribus::web
