#include "config/schema/notation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <chrono>
#include <cstdint>
#include <type_traits>
#include <variant>

#include "core/quotes.h"

namespace tribus {

std::string format_duration(Duration duration) {
    using std::chrono::microseconds;
    using std::chrono::milliseconds;
    using std::chrono::seconds;
    const auto count = duration.count();
    if (duration % seconds(1) == Duration::zero()) {
        return fmt::format("{}s", duration / seconds(1));
    }
    if (duration % milliseconds(1) == Duration::zero()) {
        return fmt::format("{}ms", duration / milliseconds(1));
    }
    return fmt::format("{}us", static_cast<double>(count) / 1000);
}

std::optional<double> parse_slew(std::string_view text) {
    const auto quantity = parse_quantity(text);
    if (!quantity || quantity->unit != "us/s") {
        return std::nullopt;
    }
    return quantity->number;
}

std::string format_slew(double microseconds_per_second) {
    return format_number(microseconds_per_second) + "us/s";
}

std::string format_number(double number) {
    return fmt::format("{}", number);
}

std::string written(SettingType type, const SettingValue& value) {
    return std::visit(
        [type](const auto& content) -> std::string {
            using Content = std::decay_t<decltype(content)>;
            if constexpr (std::is_same_v<Content, bool> || std::is_same_v<Content, std::int64_t>) {
                return fmt::format("{}", content);
            } else if constexpr (std::is_same_v<Content, double>) {
                return type == SettingType::slew ? in_quotes(format_slew(content))
                                                 : format_number(content);
            } else if constexpr (std::is_same_v<Content, std::string>) {
                return in_quotes(content);
            } else if constexpr (std::is_same_v<Content, Duration>) {
                return in_quotes(format_duration(content));
            } else if constexpr (std::is_same_v<Content, NumberRange>) {
                return fmt::format("[{}, {}]", format_number(content.low),
                                   format_number(content.high));
            } else {
                return {};
            }
        },
        value);
}

SettingValue default_of(const Setting& setting) {
    std::string_view text = setting.fallback;
    if (text.size() >= 2 && text.front() == '"' && text.back() == '"') {
        text = text.substr(1, text.size() - 2);
    }
    const char* const end = text.data() + text.size();
    switch (setting.type) {
        case SettingType::boolean:
            return text == "true";
        case SettingType::integer: {
            std::int64_t number = 0;
            std::from_chars(text.data(), end, number);
            return number;
        }
        case SettingType::number:
        case SettingType::pulse: {
            double number = 0;
            std::from_chars(text.data(), end, number);
            return number;
        }
        case SettingType::pulses: {
            NumberRange range;
            const auto low =
                std::from_chars(text.data() + std::string_view("[").size(), end, range.low);
            std::from_chars(low.ptr + std::string_view(", ").size(), end, range.high);
            return range;
        }
        case SettingType::slew:
            return parse_slew(text).value_or(0);
        case SettingType::duration:
            return parse_duration(text).value_or(Duration::zero());
        case SettingType::text:
        case SettingType::choice:
        case SettingType::scale:
        case SettingType::file:
        case SettingType::key_file:
        case SettingType::tree:
            break;
    }
    return std::string(text);
}

bool is_interface_name(std::string_view text) {
    constexpr std::size_t kLongest = 15;
    return !text.empty() && text.size() <= kLongest && text != "." && text != ".." &&
           std::ranges::none_of(text, [](char c) {
               const auto code = static_cast<unsigned char>(c);
               return c == '/' || c == ':' || std::isspace(code) != 0 || std::iscntrl(code) != 0;
           });
}

double seconds_of(Duration duration) {
    return static_cast<double>(duration.count()) / 1e9;
}

}  // namespace tribus
