#include "config/read/scale.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "config/keys/keys.h"
#include "config/language/numbers.h"
#include "config/read/value.h"
#include "config/schema/notation.h"
#include "core/quotes.h"

namespace tribus {
namespace {

constexpr std::string_view kExample = "{ raw = [172, 1811], us = [988, 2012] }";

/// Smaller slopes map two raw values to the same eighth of a microsecond; larger ones do not occur
/// with sticks.
constexpr double kLeastSlope = 0.25;
constexpr double kMostSlope = 4;
/// Range of a Pulse.
constexpr double kLeastMicroseconds = -4000;
constexpr double kMostMicroseconds = 4095;

struct Pair {
    std::array<double, 2> numbers{};
    Location where;
};

bool is_raw(double number) {
    return number == std::floor(number);
}

std::optional<Pair> read_pair(const Table& table, Location where, std::string_view name,
                              double least, double most, Mistakes& mistakes) {
    const Entry* entry = table.find(name);
    if (entry == nullptr) {
        mistakes.add(where,
                     fmt::format("the scale lacks {}; allowed: {}", in_quotes(name), kExample));
        return std::nullopt;
    }
    const auto* list = entry->value.as<List>();
    if (list != nullptr && list->items.size() == 2) {
        const auto first = number_within(list->items[0], least, most);
        const auto second = number_within(list->items[1], least, most);
        if (first && second && *first != *second &&
            (name != "raw" || (is_raw(*first) && is_raw(*second)))) {
            return Pair{{*first, *second}, entry->value.where};
        }
    }
    mistakes.add(
        entry->value.where,
        fmt::format("{} is not a list of two different {}numbers from {} to {}{}; example: {}",
                    in_quotes(name), name == "raw" ? "whole " : "", format_number(least),
                    format_number(most), without_quotes_hint(entry->value), kExample));
    return std::nullopt;
}

void check_names(const Table& table, Mistakes& mistakes) {
    constexpr std::array<std::string_view, 2> kNames{"raw", "us"};
    for (const Entry& entry : table.entries) {
        if (entry.key != kNames[0] && entry.key != kNames[1]) {
            mistakes.add(entry.where,
                         fmt::format("unknown key {} in a scale; {}", in_quotes(entry.key),
                                     suggestion(entry.key, kNames)));
        }
    }
}

}  // namespace

std::optional<TwoPoints> read_scale(std::string_view key, const Value& value, Mistakes& mistakes) {
    const Table& table = *value.as<Table>();
    check_names(table, mistakes);
    const auto raw = read_pair(table, value.where, "raw", 0, kMostRaw, mistakes);
    const auto us =
        read_pair(table, value.where, "us", kLeastMicroseconds, kMostMicroseconds, mistakes);
    if (!raw || !us) {
        return std::nullopt;
    }
    const double slope = (us->numbers[1] - us->numbers[0]) / (raw->numbers[1] - raw->numbers[0]);
    if (slope < 0) {
        const bool raw_falls = raw->numbers[0] > raw->numbers[1];
        const auto& falling = raw_falls ? raw->numbers : us->numbers;
        const std::string_view name = raw_falls ? "raw" : "us";
        mistakes.add(
            raw_falls ? raw->where : us->where,
            fmt::format("{0} is [{1}, {2}], the higher number first, unlike {3}; write "
                        "{4} = [{2}, {1}]. To reverse a channel, write reverse = true",
                        in_quotes(name), format_number(falling[0]), format_number(falling[1]),
                        in_quotes(raw_falls ? "us" : "raw"), name));
        return std::nullopt;
    }
    if (slope < kLeastSlope || slope > kMostSlope) {
        mistakes.add(value.where,
                     fmt::format("{} has a slope of {:.4g} us for each raw step; allowed: {} to {}",
                                 in_quotes(key), slope, format_number(kLeastSlope),
                                 format_number(kMostSlope)));
        return std::nullopt;
    }
    const double lowest = us->numbers[0] - slope * raw->numbers[0];
    const double highest = lowest + slope * kMostRaw;
    if (lowest < kLeastMicroseconds || highest > kMostMicroseconds) {
        mistakes.add(
            value.where,
            fmt::format(
                "{} maps raw 0 to {} to the range {:.6g} to {:.6g} us; allowed: within {} to {} us",
                in_quotes(key), format_number(kMostRaw), lowest, highest,
                format_number(kLeastMicroseconds), format_number(kMostMicroseconds)));
        return std::nullopt;
    }
    return TwoPoints{raw->numbers, us->numbers};
}

}  // namespace tribus
