#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/web/http/http.h"

/// Which requests may come from a browser at all. Pure and reentrant.
namespace tribus::web {

/// Whether a request may name this host: an address, localhost, or one of `names`, each with or
/// without a port. A page of another host whose name resolves to this machine is refused so.
bool is_own_host(std::string_view host, const std::vector<std::string>& names);

/// This machine's name, without and with `.local`, and `more`.
std::vector<std::string> own_names(std::string_view host_name,
                                   const std::vector<std::string>& more);

/// Whether the browser says that a page of another origin asks. Cookies do not tell: a page on
/// another port of the same host has them, too, and could push out the streams of its owner.
bool is_asked_by_another_page(const HttpRequest& request);

/// Why a request that changes something is refused; nothing if it may pass. It must be a POST with
/// JSON and the header X-Tribus, from a page of the same host and port. The scheme may differ: a
/// proxy may add TLS.
std::optional<HttpRefusal> why_not_from_own_page(const HttpRequest& request);

}  // namespace tribus::web
