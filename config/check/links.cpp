#include "config/check/links.h"

#include <fmt/format.h>

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

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

}  // namespace

void check_links(const Draft& draft, Mistakes& mistakes) {
    std::vector<KeptLink> links;
    collect(draft.inputs, "input", links);
    collect(draft.outputs, "output", links);
    for (std::size_t i = 0; i < links.size(); ++i) {
        for (std::size_t j = i + 1; j < links.size(); ++j) {
            if (can_be_mixed(links[i].link, links[j].link)) {
                const bool in_order = links[i].where.line <= links[j].where.line;
                const KeptLink& earlier = links[in_order ? i : j];
                const KeptLink& later = links[in_order ? j : i];
                mistakes.add(
                    later.where,
                    fmt::format("[{}.{}] has the key and the name of the link of [{}.{}] in line "
                                "{}, so that frames of one could be brought to the other; allowed: "
                                "another \"link\" for each, the same at both ends of one",
                                later.direction, later.name, earlier.direction, earlier.name,
                                earlier.where.line));
            }
        }
    }
}

}  // namespace tribus
