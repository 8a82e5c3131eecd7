#include "config/keys/words.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "config/schema/notation.h"

namespace tribus {
namespace {

std::string as_code(std::string_view text) {
    return fmt::format("`{}`", text);
}

std::string text_as_code(std::string_view text) {
    return fmt::format("`\"{}\"`", text);
}

std::string all_as_code(std::span<const std::string_view> words, bool quoted) {
    std::string text;
    for (const std::string_view word : words) {
        text += text.empty() ? "" : ", ";
        text += quoted ? text_as_code(word) : as_code(word);
    }
    return text;
}

std::string with_unit(std::string_view what, const Setting& setting) {
    return setting.unit.empty() ? std::string(what) : fmt::format("{}, {}", what, setting.unit);
}

std::string type_of_value(const Setting& setting) {
    switch (setting.type) {
        case SettingType::boolean:
            return "true or false";
        case SettingType::integer:
            return with_unit("whole number", setting);
        case SettingType::number:
            return with_unit("number", setting);
        case SettingType::text:
        case SettingType::choice:
            return "text";
        case SettingType::duration:
            return "duration";
        case SettingType::pulse:
            return "number, us";
        case SettingType::pulses:
            return fmt::format("two numbers, {}", setting.unit.empty() ? "us" : setting.unit);
        case SettingType::slew:
            return "rate";
        case SettingType::scale:
            return "text or table";
        case SettingType::file:
        case SettingType::key_file:
            return "path of a file";
        case SettingType::tree:
            return "table";
    }
    return {};
}

std::string type_of(const Key& key) {
    switch (key.kind) {
        case KeyKind::value:
            return type_of_value(key.setting);
        case KeyKind::protocol:
            return "text";
        case KeyKind::names:
            return "name, or list of names";
        case KeyKind::presets:
            return "table, us";
        case KeyKind::list:
            return "list of tables";
        case KeyKind::texts:
            return "table of texts";
        case KeyKind::line:
            return "text or whole number";
        case KeyKind::named_tables:
            return "tables with names";
        case KeyKind::weights:
        case KeyKind::table:
        case KeyKind::channels:
            return "table";
    }
    return {};
}

bool has_limits(const Setting& setting) {
    return setting.least != 0 || setting.most != 0;
}

std::string seconds_text(double seconds) {
    return format_duration(Duration(std::llround(seconds * 1e9)));
}

std::string number_range(double least, double most) {
    return fmt::format("{:.15g} to {:.15g}", least, most);
}

std::string range_of_value(const Setting& setting) {
    if (setting.type == SettingType::scale) {
        return all_as_code(setting.choices, true) + ", or `{ raw = [a, b], us = [c, d] }`";
    }
    if (!setting.choices.empty()) {
        return all_as_code(setting.choices, setting.type == SettingType::choice);
    }
    if (!has_limits(setting)) {
        return {};
    }
    if (setting.type == SettingType::duration) {
        return fmt::format("{} to {}", text_as_code(seconds_text(setting.least)),
                           text_as_code(seconds_text(setting.most)));
    }
    if (setting.type == SettingType::slew) {
        return fmt::format("{} to {}", text_as_code(format_slew(setting.least)),
                           text_as_code(format_slew(setting.most)));
    }
    return number_range(setting.least, setting.most);
}

std::string range_of(const Key& key, SettingScope way) {
    switch (key.kind) {
        case KeyKind::value:
            return range_of_value(key.setting);
        case KeyKind::protocol:
            return all_as_code(protocol_names(way), true);
        case KeyKind::presets:
            return fmt::format("channels 1 to {}, `{}`; {} each", kChannelCount, kOtherChannels,
                               number_range(kLeastPulse, kMostPulse));
        case KeyKind::weights:
            return fmt::format("channels 1 to {}; {} each", kChannelCount,
                               number_range(-kMostWeight, kMostWeight));
        case KeyKind::channels:
            return fmt::format("channels 1 to {}", kChannelCount);
        default:
            return {};
    }
}

std::string fallback_of(const Key& key) {
    const Setting& setting = key.setting;
    if (setting.required) {
        return "required";
    }
    if (const auto value = default_of(key)) {
        return as_code(written(setting.type, *value));
    }
    return setting.absent.empty() ? "none" : std::string(setting.absent);
}

std::string_view example_of(const Setting& setting, SettingScope way) {
    const bool other = way == SettingScope::output && !setting.output_example.empty();
    return other ? setting.output_example : setting.example;
}

}  // namespace

KeyWords words_of(const Key& key, SettingScope way) {
    const Setting& setting = key.setting;
    return {.type = type_of(key),
            .range = range_of(key, way),
            .fallback = fallback_of(key),
            .meaning = fmt::format("{}.", setting.help),
            .example = fmt::format("{} = {}", setting.key, example_of(setting, way))};
}

std::string help_with_default(const Setting& setting) {
    return setting.absent.empty() ? std::string(setting.help)
                                  : fmt::format("{}. Default: {}", setting.help, setting.absent);
}

std::string without_backticks(std::string_view text) {
    std::string plain(text);
    std::erase(plain, '`');
    return plain;
}

}  // namespace tribus
