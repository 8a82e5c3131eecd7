#include "transports/codecs/authenticated/link_settings.h"

#include "core/quotes.h"

namespace tribus::authenticated {

std::optional<LinkWithKey> link_of(const SettingValues& settings, const std::string& place) {
    const auto* file = settings.find_as<KeyFile>("key");
    if (file == nullptr) {
        return std::nullopt;
    }
    const auto* old = settings.find_as<KeyFile>("old_key");
    const auto* epoch = settings.find_as<std::string>("epoch");
    const auto* link = settings.find_as<std::string>("link");
    const bool named = link != nullptr && !link->empty();
    return LinkWithKey{.name = named ? place + " " + *link : place,
                       .secret = file->secret,
                       .old_secret = old == nullptr ? std::nullopt : std::optional(old->secret),
                       .epoch = epoch == nullptr ? std::nullopt : std::optional(*epoch)};
}

void check_link(const SettingValues& settings, std::vector<SettingMistake>& mistakes) {
    const auto* epoch = settings.find_as<std::string>("epoch");
    if (epoch != nullptr && (!epoch->starts_with('/') || epoch->ends_with('/'))) {
        mistakes.push_back({{"epoch"},
                            in_quotes("epoch") + " is " + in_quotes(*epoch) +
                                "; allowed: the whole path of a file, such as "
                                "\"/var/lib/tribus/boat.epoch\""});
    }
    if (settings.find("key") != nullptr) {
        return;
    }
    for (const char* const key : {"old_key", "link", "epoch"}) {
        if (settings.find(key) != nullptr) {
            mistakes.push_back({{key},
                                "\"" + std::string(key) +
                                    "\" has no effect without \"key\"; add key, or leave it out"});
        }
    }
}

}  // namespace tribus::authenticated
