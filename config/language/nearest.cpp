#include "config/language/nearest.h"

#include <algorithm>
#include <vector>

namespace tribus {
namespace {

/// Longer words are not misspelt names. Limits the time, which grows with the product of the
/// lengths.
constexpr std::size_t kLongestWord = 64;

char lower(char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

}  // namespace

std::size_t edit_distance(std::string_view a, std::string_view b) {
    const std::size_t width = b.size() + 1;
    std::vector<std::size_t> table((a.size() + 1) * width);
    const auto at = [&](std::size_t i, std::size_t j) -> std::size_t& {
        return table[i * width + j];
    };
    for (std::size_t i = 0; i <= a.size(); ++i) {
        for (std::size_t j = 0; j <= b.size(); ++j) {
            if (i == 0 || j == 0) {
                at(i, j) = i + j;
                continue;
            }
            const char x = lower(a[i - 1]);
            const char y = lower(b[j - 1]);
            at(i, j) = std::min(
                {at(i - 1, j) + 1, at(i, j - 1) + 1, at(i - 1, j - 1) + (x == y ? 0U : 1U)});
            if (i > 1 && j > 1 && x == lower(b[j - 2]) && y == lower(a[i - 2])) {
                at(i, j) = std::min(at(i, j), at(i - 2, j - 2) + 1);
            }
        }
    }
    return at(a.size(), b.size());
}

std::optional<std::string_view> nearest(std::string_view wrong,
                                        std::span<const std::string_view> candidates) {
    std::optional<std::string_view> best;
    std::size_t fewest = 0;
    if (wrong.size() > kLongestWord) {
        return best;
    }
    for (const std::string_view candidate : candidates) {
        const std::size_t longer = std::max(wrong.size(), candidate.size());
        const std::size_t distance = edit_distance(wrong, candidate);
        const std::size_t most = std::max<std::size_t>(1, longer / 3);
        if (distance <= most && distance < longer && (!best || distance < fewest)) {
            best = candidate;
            fewest = distance;
        }
    }
    return best;
}

}  // namespace tribus
