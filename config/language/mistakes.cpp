#include "config/language/mistakes.h"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>

#include "config/language/nearest.h"
#include "core/quotes.h"

namespace tribus {

std::string format_mistake(const Mistake& mistake) {
    if (mistake.where.line == 0) {
        return fmt::format("{}: {}", mistake.file, mistake.text);
    }
    return fmt::format("{}:{}:{}: {}", mistake.file, mistake.where.line, mistake.where.column,
                       mistake.text);
}

bool may_be_temporary(std::span<const Mistake> mistakes) {
    return !mistakes.empty() && std::ranges::all_of(mistakes, &Mistake::out_of_reach);
}

bool Mistakes::on_line(unsigned line) const {
    return std::any_of(mistakes_.begin(), mistakes_.end(),
                       [line](const Mistake& mistake) { return mistake.where.line == line; });
}

std::vector<Mistake> Mistakes::sorted() const {
    std::vector<Mistake> sorted = mistakes_;
    std::stable_sort(sorted.begin(), sorted.end(), [](const Mistake& a, const Mistake& b) {
        return std::tie(a.where.line, a.where.column) < std::tie(b.where.line, b.where.column);
    });
    return sorted;
}

std::string suggestion(std::string_view wrong, std::span<const std::string_view> allowed) {
    if (const auto near = nearest(wrong, allowed)) {
        return fmt::format("did you mean {}? Allowed: {}", in_quotes(*near),
                           in_quotes_all(allowed));
    }
    return allowed.empty() ? "there is none" : fmt::format("allowed: {}", in_quotes_all(allowed));
}

}  // namespace tribus
