#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "app/web/http/http.h"
#include "app/web/pairing/pairing.h"

/// The table of what the page may ask, and who may ask it. Pure.
namespace tribus::web {

enum class Access : std::uint8_t {
    anybody,  ///< who reaches the page
    looks,    ///< a paired browser
    changes,  ///< a paired browser with the role `change`
};

struct Route {
    std::string_view method;  ///< GET changes nothing; POST is for pages of our own (access.h)
    std::string_view path;    ///< a part `*` stands for any name; at most two
    Access access = Access::changes;
};

/// Names that stand for the parts `*` of a path, decoded (RFC 3986, 2.1), in their order.
using PathNames = std::array<std::string, 2>;

/// The names, if the path is one of that route. A name is not empty and is UTF-8.
std::optional<PathNames> names_in(const Route& route, std::string_view path);

inline constexpr std::string_view kMayOnlyLook =
    "this browser may only look; `sudo tribus pair` lets it change";

/// Why the request is refused; nothing if this role may make it. `role`: nothing for a browser that
/// is not paired.
std::optional<HttpRefusal> why_not(const Route& route, const HttpRequest& request,
                                   std::optional<Role> role);

}  // namespace tribus::web
