#include "app/web/pairing/pairing_pauses.h"

#include <algorithm>

namespace tribus::web {

Duration PairingPauses::left(const std::string& address, Instant now) const {
    const auto pause = pauses_.find(address);
    return pause == pauses_.end() ? Duration::zero()
                                  : std::max(pause->second.end - now, Duration::zero());
}

Duration PairingPauses::wrong(const std::string& address, Instant now) {
    std::erase_if(pauses_, [now](const auto& one) { return now - one.second.end > kForgotten; });
    if (pauses_.size() >= kMostAddresses && !pauses_.contains(address)) {
        pauses_.erase(
            std::ranges::min_element(pauses_, {}, [](const auto& one) { return one.second.end; }));
    }
    Pause& pause = pauses_[address];
    pause.length = std::clamp(2 * pause.length, kFirst, kLongest);
    pause.end = later(now, pause.length);
    return pause.length;
}

}  // namespace tribus::web
