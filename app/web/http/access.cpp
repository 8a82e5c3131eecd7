#include "app/web/http/access.h"

#include <arpa/inet.h>
#include <netinet/in.h>

#include <algorithm>
#include <cctype>

namespace tribus::web {
namespace {

std::string lower(std::string_view text) {
    std::string low(text);
    std::ranges::transform(low, low.begin(), [](unsigned char c) { return std::tolower(c); });
    return low;
}

bool is_port(std::string_view text) {
    return !text.empty() && text.size() <= 5 &&
           std::ranges::all_of(text, [](unsigned char c) { return std::isdigit(c) != 0; });
}

/// The host without its port. Nothing if it is no host.
std::optional<std::string> name_in(std::string_view host) {
    if (host.find('\0') != std::string_view::npos) {
        return std::nullopt;
    }
    if (host.starts_with('[')) {
        const std::size_t end = host.find(']');
        const std::string_view port = end == std::string_view::npos ? "x" : host.substr(end + 1);
        in6_addr address{};
        const std::string inside(host.substr(1, end == std::string_view::npos ? end : end - 1));
        const bool right = ::inet_pton(AF_INET6, inside.c_str(), &address) == 1 &&
                           (port.empty() || (port.front() == ':' && is_port(port.substr(1))));
        return right ? std::optional(lower(host.substr(0, end + 1))) : std::nullopt;
    }
    const std::size_t colon = host.find(':');
    if (colon != std::string_view::npos && !is_port(host.substr(colon + 1))) {
        return std::nullopt;
    }
    return lower(host.substr(0, colon));
}

}  // namespace

bool is_own_host(std::string_view host, const std::vector<std::string>& names) {
    const auto name = name_in(host);
    in_addr address{};
    return name && (name->starts_with('[') || *name == "localhost" ||
                    ::inet_pton(AF_INET, name->c_str(), &address) == 1 ||
                    std::ranges::find(names, *name) != names.end());
}

std::vector<std::string> own_names(std::string_view host_name,
                                   const std::vector<std::string>& more) {
    std::vector<std::string> names;
    if (!host_name.empty()) {
        const std::string name = lower(host_name);
        names = {name, name + ".local"};
    }
    std::ranges::transform(more, std::back_inserter(names),
                           [](const std::string& name) { return lower(name); });
    return names;
}

bool is_asked_by_another_page(const HttpRequest& request) {
    const std::string& from = request.fetch_site;
    return !from.empty() && from != "same-origin" && from != "none";
}

std::optional<HttpRefusal> why_not_from_own_page(const HttpRequest& request) {
    if (request.method != "POST") {
        return HttpRefusal{405, "only POST changes something"};
    }
    const std::string_view type =
        std::string_view(request.content_type).substr(0, request.content_type.find(';'));
    if (type != "application/json") {
        return HttpRefusal{415, "the content must be application/json"};
    }
    if (!request.marked) {
        return HttpRefusal{403, "the header X-Tribus: 1 is missing"};
    }
    if (!request.origin) {
        return HttpRefusal{403, "the header Origin is missing"};
    }
    const std::string_view origin = *request.origin;
    const std::size_t host = origin.find("://");
    if (host == std::string_view::npos || lower(origin.substr(host + 3)) != lower(request.host)) {
        return HttpRefusal{403, "the request comes from a page of another address"};
    }
    return std::nullopt;
}

}  // namespace tribus::web
