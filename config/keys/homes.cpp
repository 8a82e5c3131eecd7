#include "config/keys/homes.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <span>
#include <vector>

#include "config/keys/keys.h"
#include "core/quotes.h"
#include "transports/registry/registry.h"

namespace tribus {
namespace {

std::string path_inside(const Key& key, const std::string& path) {
    const std::string inside =
        path.empty() ? std::string(key.name()) : fmt::format("{}.{}", path, key.name());
    return key.kind == KeyKind::named_tables ? inside + ".NAME" : inside;
}

std::string home_in_protocols(std::string_view name, const Key& tables, std::string_view only) {
    for (const Protocol* protocol : protocols()) {
        if (!only.empty() && protocol->name != only) {
            continue;
        }
        const auto media = media_for(*protocol);
        const auto knows = [&](const Medium* medium) {
            return std::ranges::count(protocol_keys(*protocol, *medium, *tables.protocol_scope),
                                      name, &Key::name) > 0;
        };
        const auto first = std::ranges::find_if(media, knows);
        if (first != media.end()) {
            return fmt::format(
                "[{}.NAME] with protocol {}{}", tables.name(), in_quotes(protocol->name),
                std::ranges::all_of(media, knows) ? "" : " and " + in_quotes((*first)->place.key));
        }
    }
    return {};
}

/// Recurses through the three levels of the key table.
std::string home_in(std::string_view name, std::span<const Key> keys, const std::string& path,
                    std::string_view only) {
    for (const Key& key : keys) {
        if (key.name() == name && !path.empty()) {
            return fmt::format("[{}]", path);
        }
    }
    for (const Key& key : keys) {
        std::string home = home_in(name, key.inside, path_inside(key, path), only);
        if (home.empty() && key.protocol_scope) {
            home = home_in_protocols(name, key, only);
        }
        if (!home.empty()) {
            return home;
        }
    }
    return {};
}

}  // namespace

std::string home_of_key(std::string_view name, std::string_view side, std::string_view protocol) {
    const std::span<const Key> all = root_keys();
    const std::span<const Key> own = side.empty() ? all : std::span(&key_named(all, side), 1);
    std::vector<Key> ports;
    std::ranges::copy_if(all, std::back_inserter(ports),
                         [](const Key& key) { return key.protocol_scope.has_value(); });
    std::string home = home_in(name, own, {}, protocol);
    if (home.empty() && !protocol.empty()) {
        home = home_in(name, ports, {}, protocol);
    }
    for (const auto keys : {own, all}) {
        home = home.empty() ? home_in(name, keys, {}, {}) : home;
    }
    return home;
}

}  // namespace tribus
