#include "config/check/links.h"

#include <fmt/format.h>

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "config/check/pairs.h"
#include "core/quotes.h"

namespace tribus {
namespace {

struct KeptLink {
    std::string_view direction;
    std::string_view name;
    Location where;
    LinkWithKey link;
};

bool counts_for(const SecretKey& secret, const LinkWithKey& link) {
    return secret == link.secret || secret == link.old_secret;
}

/// Whether messages of one could count for the other.
bool can_be_mixed(const LinkWithKey& a, const LinkWithKey& b) {
    return a.name == b.name && (counts_for(a.secret, b) || counts_for(b.secret, a) ||
                                (a.old_secret && a.old_secret == b.old_secret));
}

template <class Drafts>
void collect(const Drafts& drafts, std::string_view direction, std::vector<KeptLink>& links) {
    for (const auto& part : drafts) {
        if (const auto link = part.settings_sound ? link_with_key(part.config) : std::nullopt) {
            links.push_back({direction, part.config.name, part.where, *link});
        }
    }
}

std::optional<std::filesystem::path> epoch_file(const LinkWithKey& link) {
    return link.epoch ? std::optional(std::filesystem::path(*link.epoch).lexically_normal())
                      : std::nullopt;
}

bool share_their_numbers(const LinkWithKey& a, const LinkWithKey& b) {
    return a.epoch && epoch_file(a) == epoch_file(b);
}

void compare(const KeptLink& earlier, const KeptLink& later, Mistakes& mistakes) {
    if (can_be_mixed(earlier.link, later.link)) {
        mistakes.add(
            later.where,
            fmt::format("[{}.{}] has the key and the name of the link of [{}.{}] in line {}, so "
                        "that frames of one could be brought to the other; allowed: another "
                        "\"link\" for each, the same at both ends of one",
                        later.direction, later.name, earlier.direction, earlier.name,
                        earlier.where.line));
    }
    if (share_their_numbers(earlier.link, later.link)) {
        mistakes.add(later.where,
                     fmt::format("[{}.{}] has the epoch file of [{}.{}] in line {}; allowed: "
                                 "another file for each, because one would use up the numbers of "
                                 "the other",
                                 later.direction, later.name, earlier.direction, earlier.name,
                                 earlier.where.line));
    }
}

}  // namespace

void check_links(const Draft& draft, Mistakes& mistakes) {
    std::vector<KeptLink> links;
    collect(draft.inputs, "input", links);
    collect(draft.outputs, "output", links);
    for_each_pair(
        std::move(links), [](const KeptLink& link) { return link.where.line; },
        [&](const KeptLink& earlier, const KeptLink& later) { compare(earlier, later, mistakes); });
}

}  // namespace tribus
