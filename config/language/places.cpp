#include "config/language/places.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>

namespace tribus {

std::string RepeatedMistake::further_lines() const {
    constexpr std::size_t kMostNamed = 5;
    if (lines_.size() < 2) {
        return {};
    }
    const auto further = std::span(lines_).subspan(1);
    const auto named = further.first(std::min(further.size(), kMostNamed));
    const std::size_t more = further.size() - named.size();
    return fmt::format(" (also in line{} {}{})", further.size() == 1 ? "" : "s",
                       fmt::join(named, ", "),
                       more == 0 ? std::string() : fmt::format(" and {} more", more));
}

}  // namespace tribus
