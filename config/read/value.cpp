#include "config/read/value.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <utility>

#include "config/keys/keys.h"
#include "config/language/key_file.h"
#include "config/language/numbers.h"
#include "config/language/read_tree.h"
#include "config/read/scale.h"
#include "config/schema/notation.h"
#include "core/quotes.h"

namespace tribus {
namespace {

bool limited(const Setting& setting) {
    return setting.least != 0 || setting.most != 0;
}

bool within(const Setting& setting, double number) {
    return !limited(setting) || (number >= setting.least && number <= setting.most);
}

std::string format_seconds(double seconds) {
    return in_quotes(format_duration(Duration(std::llround(seconds * 1e9))));
}

std::string range(const Setting& setting) {
    if (!limited(setting)) {
        return {};
    }
    switch (setting.type) {
        case SettingType::duration:
            return fmt::format(" from {} to {}", format_seconds(setting.least),
                               format_seconds(setting.most));
        case SettingType::slew:
            return fmt::format(" from {} to {}", in_quotes(format_slew(setting.least)),
                               in_quotes(format_slew(setting.most)));
        default:
            return fmt::format(" from {} to {}", format_number(setting.least),
                               format_number(setting.most));
    }
}

std::string one_of(const Setting& setting) {
    if (setting.type != SettingType::integer) {
        return in_quotes_all(setting.choices);
    }
    return fmt::format("{}", fmt::join(setting.choices, ", "));
}

bool is_choice(const Setting& setting, std::string_view text) {
    return setting.choices.empty() ||
           std::find(setting.choices.begin(), setting.choices.end(), text) != setting.choices.end();
}

std::optional<SettingValue> read_integer(const Setting& setting, const Value& value) {
    const auto* number = value.as<std::int64_t>();
    if (number == nullptr || !within(setting, static_cast<double>(*number)) ||
        !is_choice(setting, fmt::format("{}", *number))) {
        return std::nullopt;
    }
    return *number;
}

std::optional<SettingValue> read_number(const Setting& setting, const Value& value) {
    const double infinity = std::numeric_limits<double>::max();
    const auto number = limited(setting) ? number_within(value, setting.least, setting.most)
                                         : number_within(value, -infinity, infinity);
    return number ? std::optional<SettingValue>(*number) : std::nullopt;
}

/// Two numbers within the limits, the lower one first.
std::optional<SettingValue> read_range(const Setting& setting, const Value& value) {
    const auto* list = value.as<List>();
    if (list == nullptr || list->items.size() != 2) {
        return std::nullopt;
    }
    const auto low = number_within(list->items[0], setting.least, setting.most);
    const auto high = number_within(list->items[1], setting.least, setting.most);
    // Nothing is less than any number.
    return low && low <= high ? std::optional<SettingValue>(NumberRange{*low, *high})
                              : std::nullopt;
}

/// A control character could make a part of the text look like a line of its own in a log.
bool has_control_characters(std::string_view text) {
    return std::ranges::any_of(
        text, [](char c) { return std::iscntrl(static_cast<unsigned char>(c)) != 0; });
}

bool text_allowed(const Setting& setting, const std::string& text) {
    return names_interface(setting) ? is_interface_name(text)
                                    : !text.empty() && !has_control_characters(text);
}

std::optional<SettingValue> read_text(const Setting& setting, const std::string& text) {
    switch (setting.type) {
        case SettingType::duration: {
            const auto duration = parse_duration(text);
            return duration && within(setting, seconds_of(*duration))
                       ? std::optional<SettingValue>(*duration)
                       : std::nullopt;
        }
        case SettingType::slew: {
            const auto slew = parse_slew(text);
            return slew && within(setting, *slew) ? std::optional<SettingValue>(*slew)
                                                  : std::nullopt;
        }
        case SettingType::text:
            return text_allowed(setting, text) ? std::optional<SettingValue>(text) : std::nullopt;
        default:
            return is_choice(setting, text) ? std::optional<SettingValue>(text) : std::nullopt;
    }
}

std::optional<SettingValue> read_plain(const Setting& setting, const Value& value) {
    switch (setting.type) {
        case SettingType::boolean: {
            const auto* truth = value.as<bool>();
            return truth != nullptr ? std::optional<SettingValue>(*truth) : std::nullopt;
        }
        case SettingType::integer:
            return read_integer(setting, value);
        case SettingType::number:
        case SettingType::pulse:
            return read_number(setting, value);
        case SettingType::pulses:
            return read_range(setting, value);
        default: {
            const auto* text = value.as<std::string>();
            return text != nullptr ? read_text(setting, *text) : std::nullopt;
        }
    }
}

/// For an example. The default is a safe one.
std::string usual_duration(const Key& key) {
    const auto value = default_of(key);
    return value ? written(key.setting.type, *value) : "\"14ms\"";
}

/// What the value should be, if it is a range with its numbers in the wrong order.
std::optional<std::string> turned_range(const Setting& setting, const Value& value) {
    const auto* list = value.as<List>();
    if (setting.type != SettingType::pulses || list == nullptr || list->items.size() != 2) {
        return std::nullopt;
    }
    const Value turned{value.where, List{{list->items[1], list->items[0]}}};
    return read_range(setting, turned) ? std::optional(describe(turned)) : std::nullopt;
}

bool is_written_in_quotes(SettingType type) {
    switch (type) {
        case SettingType::boolean:
        case SettingType::integer:
        case SettingType::number:
        case SettingType::pulse:
        case SettingType::pulses:
            return false;
        default:
            return true;
    }
}

/// What to do about a text that has a control character. It is often a path with backslashes.
std::string without_control_characters_hint(std::string_view text) {
    constexpr std::string_view kMadeByEscapes = "\b\t\n\f\r";
    return fmt::format(", without control characters{}",
                       text.find_first_of(kMadeByEscapes) == std::string_view::npos
                           ? ""
                           : "; a backslash begins an escape between \", and stands for itself "
                             "between '");
}

std::string what_to_write(const Key& key, const Value& value) {
    const Setting& setting = key.setting;
    const auto* text = value.as<std::string>();
    const bool quoted = is_written_in_quotes(setting.type);
    if (text != nullptr && quoted && !setting.choices.empty()) {
        return suggestion(*text, setting.choices);
    }
    if (const auto turned = turned_range(setting, value)) {
        return fmt::format("the lower number comes first: {} = {}", setting.key, *turned);
    }
    const auto inside = quoted ? std::nullopt : value_in_text(value);
    if (inside && read_plain(setting, *inside)) {
        return fmt::format("leave the quotes out: {} = {}", setting.key, bare_text(value));
    }
    return "allowed: " + allowed_values(key) +
           std::string(quoted ? "" : without_quotes_hint(value)) +
           (text != nullptr && has_control_characters(*text)
                ? without_control_characters_hint(*text)
                : "");
}

}  // namespace

std::string allowed_values(const Key& key) {
    const Setting& setting = key.setting;
    const std::string limits = range(setting);
    switch (setting.type) {
        case SettingType::boolean:
            return "true or false";
        case SettingType::integer:
            return setting.choices.empty() ? "a whole number" + limits : one_of(setting);
        case SettingType::number:
            return "a number" + limits;
        case SettingType::text:
            return names_interface(setting)
                       ? "the name of an interface, 1 to 15 characters without blanks, \"/\" and "
                         "\":\""
                       : "text in quotes, not empty";
        case SettingType::choice:
            return one_of(setting);
        case SettingType::duration:
            return fmt::format("a duration{}, text with a unit (us, ms, s) such as {}", limits,
                               usual_duration(key));
        case SettingType::pulse:
            return "microseconds" + limits;
        case SettingType::pulses:
            return fmt::format("two numbers of microseconds{}, the lower one first: {}", limits,
                               setting.example.empty() ? "[985, 995]" : setting.example);
        case SettingType::slew:
            return fmt::format("microseconds per second{}, text such as \"2000us/s\"", limits);
        case SettingType::file:
            return "the path of a text file";
        case SettingType::key_file:
            return "the path of a key file";
        case SettingType::tree:
            return "a table";
        case SettingType::scale:
            break;
    }
    return one_of(setting) + ", or two points: { raw = [172, 1811], us = [988, 2012] }";
}

std::optional<SettingValue> read_value(const Key& key, const Value& value, Mistakes& mistakes) {
    const Setting& setting = key.setting;
    if (setting.type == SettingType::scale && value.as<Table>() != nullptr) {
        const auto points = read_scale(setting.key, value, mistakes);
        return points ? std::optional<SettingValue>(*points) : std::nullopt;
    }
    if (setting.type == SettingType::tree) {
        auto tree = read_tree(setting.key, value, mistakes);
        return tree ? std::optional<SettingValue>(std::move(*tree)) : std::nullopt;
    }
    if (setting.type == SettingType::file) {
        auto file = read_named_file(setting.key, value, mistakes);
        return file ? std::optional<SettingValue>(std::move(*file)) : std::nullopt;
    }
    if (setting.type == SettingType::key_file) {
        auto file = read_key_file(setting.key, value, mistakes);
        return file ? std::optional<SettingValue>(std::move(*file)) : std::nullopt;
    }
    auto result = read_plain(setting, value);
    if (!result) {
        mistakes.add(value.where, fmt::format("{} is {}; {}", in_quotes(setting.key),
                                              describe(value), what_to_write(key, value)));
    }
    return result;
}

std::optional<double> read_pulse(std::string_view key, const Value& value, Mistakes& mistakes) {
    const Setting setting{
        .key = key, .type = SettingType::pulse, .least = kLeastPulse, .most = kMostPulse};
    const auto pulse = read_value({setting}, value, mistakes);
    return pulse ? std::optional(std::get<double>(*pulse)) : std::nullopt;
}

std::optional<double> number_within(const Value& value, double least, double most) {
    const auto* whole = value.as<std::int64_t>();
    const auto* fractional = value.as<double>();
    if (whole == nullptr && fractional == nullptr) {
        return std::nullopt;
    }
    const double number = whole != nullptr ? static_cast<double>(*whole) : *fractional;
    return number >= least && number <= most ? std::optional(number) : std::nullopt;
}

}  // namespace tribus
