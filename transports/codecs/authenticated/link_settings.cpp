#include "transports/codecs/authenticated/link_settings.h"

namespace tribus::authenticated {

std::optional<LinkWithKey> link_of(const SettingValues& settings, const std::string& place) {
    const auto* file = settings.find_as<KeyFile>("key");
    if (file == nullptr) {
        return std::nullopt;
    }
    const auto* old = settings.find_as<KeyFile>("old_key");
    return LinkWithKey{place + " " + settings.get_or<std::string>("link", ""), file->secret,
                       old == nullptr ? std::nullopt : std::optional(old->secret)};
}

void check_link(const SettingValues& settings, std::vector<SettingMistake>& mistakes) {
    if (settings.find("key") != nullptr) {
        return;
    }
    for (const char* const key : {"old_key", "link"}) {
        if (settings.find(key) != nullptr) {
            mistakes.push_back({{key},
                                "\"" + std::string(key) +
                                    "\" has no effect without \"key\"; add key, or leave it out"});
        }
    }
}

}  // namespace tribus::authenticated
