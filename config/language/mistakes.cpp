#include "config/language/mistakes.h"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>

#include "config/language/nearest.h"
#include "core/quotes.h"

namespace tribus {
namespace {

/// `199,900`
std::string in_thousands(std::size_t number) {
    std::string text = std::to_string(number);
    for (std::size_t at = text.size(); at > 3;) {
        at -= 3;
        text.insert(at, ",");
    }
    return text;
}

}  // namespace

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

void Mistakes::add(Mistake mistake) {
    if (full()) {
        count(1, mistake.out_of_reach);
    } else {
        mistakes_.push_back(std::move(mistake));
    }
}

void Mistakes::add(const Mistakes& others) {
    for (const Mistake& mistake : others.mistakes_) {
        add(mistake);
    }
    count(others.further_, others.further_out_of_reach_);
}

void Mistakes::count(std::size_t further, bool out_of_reach) {
    further_ += further;
    further_out_of_reach_ = further_out_of_reach_ && out_of_reach;
}

Mistakes Mistakes::without_lines_of(const Mistakes& others) const {
    Mistakes own(file_);
    for (const Mistake& mistake : mistakes_) {
        if (!others.on_line(mistake.where.line)) {
            own.add(mistake);
        }
    }
    own.count(further_, further_out_of_reach_);
    return own;
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
    if (further_ > 0) {
        sorted.push_back(
            {file_, {}, fmt::format("and {} more", in_thousands(further_)), further_out_of_reach_});
    }
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
