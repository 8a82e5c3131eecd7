#include "core/quantity.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <system_error>
#include <utility>

namespace tribus {
namespace {

constexpr double kNanosecondsPerSecond = 1e9;
constexpr double kLongestDurationNanoseconds = 366.0 * 24 * 3600 * kNanosecondsPerSecond;

bool is_digit(char c) {
    return c >= '0' && c <= '9';
}

constexpr std::array<std::pair<std::string_view, double>, 3> kTimeUnits{
    {{"us", 1e3}, {"ms", 1e6}, {"s", kNanosecondsPerSecond}}};

}  // namespace

std::optional<Quantity> parse_quantity(std::string_view text) {
    std::size_t end = 0;
    const auto take_digits = [&] {
        const std::size_t begin = end;
        while (end < text.size() && is_digit(text[end])) {
            ++end;
        }
        return end > begin;
    };
    if (!take_digits()) {
        return std::nullopt;
    }
    if (end < text.size() && text[end] == '.') {
        ++end;
        if (!take_digits()) {
            return std::nullopt;
        }
    }
    Quantity quantity{.unit = text.substr(end)};
    const auto [stop, error] = std::from_chars(text.data(), text.data() + end, quantity.number);
    if (error != std::errc{} || stop != text.data() + end) {
        return std::nullopt;
    }
    return quantity;
}

std::optional<Duration> parse_duration(std::string_view text) {
    const auto quantity = parse_quantity(text);
    if (!quantity) {
        return std::nullopt;
    }
    for (const auto& [unit, nanoseconds] : kTimeUnits) {
        const double total = quantity->number * nanoseconds;
        if (quantity->unit == unit && total <= kLongestDurationNanoseconds) {
            return Duration(std::llround(total));
        }
    }
    return std::nullopt;
}

}  // namespace tribus
