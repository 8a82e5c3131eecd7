#include "config/language/numbers.h"

#include <algorithm>
#include <cctype>
#include <utility>

#include "config/language/parse_toml.h"

namespace tribus {
namespace {

bool is_digits(std::string_view text) {
    return !text.empty() && std::ranges::all_of(text, [](char c) {
        return std::isdigit(static_cast<unsigned char>(c)) != 0 || c == '_';
    });
}

bool has_large_prefix(std::string_view word) {
    return word.size() > 2 && word[0] == '0' &&
           (word[1] == 'X' || word[1] == 'O' || word[1] == 'B');
}

std::string_view without_leading_zeros(std::string_view digits) {
    const std::size_t first = digits.find_first_not_of("0_");
    return first == std::string_view::npos ? "0" : digits.substr(first);
}

}  // namespace

std::optional<NumberRepair> repaired_number(std::string_view word) {
    const bool has_sign = word.starts_with('-') || word.starts_with('+');
    const std::string sign(word.substr(0, has_sign ? 1 : 0));
    const std::string_view number = word.substr(sign.size());
    if (has_large_prefix(number) && !has_sign) {
        std::string small(number);
        small[1] = static_cast<char>(std::tolower(static_cast<unsigned char>(small[1])));
        return NumberRepair{std::move(small), "0x, 0o and 0b have small letters"};
    }
    const std::size_t point = number.find('.');
    const bool has_point = point != std::string_view::npos;
    const std::string_view whole = number.substr(0, point);
    const std::string_view rest = has_point ? number.substr(point + 1) : std::string_view{};
    if ((!whole.empty() && !is_digits(whole)) || (!rest.empty() && !is_digits(rest)) ||
        (whole.empty() && rest.empty())) {
        return std::nullopt;
    }
    if (has_point && (whole.empty() || rest.empty())) {
        return NumberRepair{sign + std::string(whole.empty() ? "0" : without_leading_zeros(whole)) +
                                "." + std::string(rest.empty() ? "0" : rest),
                            "a decimal point has digits on both sides"};
    }
    if (whole.size() > 1 && whole[0] == '0') {
        return NumberRepair{sign + std::string(without_leading_zeros(whole)) +
                                std::string(has_point ? number.substr(point) : ""),
                            "a number does not begin with 0"};
    }
    return std::nullopt;
}

std::optional<Value> value_in_text(const Value& value) {
    const auto* text = value.as<std::string>();
    if (text == nullptr || text->find_first_of("\n#") != std::string::npos) {
        return std::nullopt;
    }
    const auto repair = repaired_number(*text);
    auto table = parse_toml("value = " + (repair ? repair->number : *text));
    if (!table) {
        return std::nullopt;
    }
    Value inside = std::move(table->entries.front().value);
    inside.where = value.where;
    const bool bare = inside.as<bool>() != nullptr || inside.as<std::int64_t>() != nullptr ||
                      inside.as<double>() != nullptr;
    return bare ? std::optional(std::move(inside)) : std::nullopt;
}

std::string bare_text(const Value& value) {
    const auto& text = *value.as<std::string>();
    const auto repair = repaired_number(text);
    return repair ? repair->number : text;
}

std::string_view without_quotes_hint(const Value& value) {
    const auto* list = value.as<List>();
    const bool quotes = list == nullptr ? value_in_text(value).has_value()
                                        : std::ranges::any_of(list->items, [](const Value& item) {
                                              return value_in_text(item).has_value();
                                          });
    return quotes ? ", without quotes" : "";
}

}  // namespace tribus
