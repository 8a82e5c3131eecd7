#include "app/web/server/routes.h"

#include <algorithm>
#include <charconv>

#include "app/web/http/access.h"
#include "core/utf8.h"

namespace tribus::web {
namespace {

/// The part of a path up to the next '/', which is removed, too.
std::string_view take_part(std::string_view& path) {
    const std::size_t end = path.find('/');
    const std::string_view part = path.substr(0, end);
    path.remove_prefix(end == std::string_view::npos ? path.size() : end + 1);
    return part;
}

std::optional<std::string> decoded(std::string_view part) {
    std::string name;
    while (!part.empty()) {
        if (part.front() != '%') {
            name += part.front();
            part.remove_prefix(1);
            continue;
        }
        unsigned char byte = 0;
        const char* const end = part.data() + std::min<std::size_t>(part.size(), 3);
        if (part.size() < 3 || std::from_chars(part.data() + 1, end, byte, 16).ptr != end) {
            return std::nullopt;
        }
        name += static_cast<char>(byte);
        part.remove_prefix(3);
    }
    return name.empty() || !is_utf8(name) ? std::nullopt : std::optional(std::move(name));
}

}  // namespace

std::optional<PathNames> names_in(const Route& route, std::string_view path) {
    PathNames names;
    std::size_t count = 0;
    std::string_view pattern = route.path;
    if (std::ranges::count(pattern, '/') != std::ranges::count(path, '/')) {
        return std::nullopt;
    }
    while (!pattern.empty()) {
        const std::string_view wanted = take_part(pattern);
        const std::string_view part = take_part(path);
        if (wanted != "*") {
            if (part != wanted) {
                return std::nullopt;
            }
            continue;
        }
        auto name = decoded(part);
        if (!name) {
            return std::nullopt;
        }
        names[count++] = *std::move(name);
    }
    return names;
}

std::optional<HttpRefusal> why_not(const Route& route, const HttpRequest& request,
                                   std::optional<Role> role) {
    if (route.access != Access::anybody && !role) {
        return HttpRefusal{401, "this browser is not paired; `sudo tribus pair` prints a code"};
    }
    if (route.method == "POST") {
        if (auto why = why_not_from_own_page(request)) {
            return why;
        }
    }
    if (route.access == Access::changes && role != Role::change) {
        return HttpRefusal{403, std::string(kMayOnlyLook)};
    }
    return std::nullopt;
}

}  // namespace tribus::web
