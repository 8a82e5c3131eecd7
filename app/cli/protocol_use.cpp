#include "app/cli/protocol_use.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <iterator>
#include <optional>
#include <utility>

#include "config/keys/words.h"
#include "config/language/document.h"
#include "config/language/mistakes.h"
#include "config/language/numbers.h"
#include "config/language/parse_toml.h"
#include "config/language/protocol_words.h"
#include "config/read/value.h"
#include "config/schema/notation.h"
#include "core/quotes.h"
#include "transports/registry/registry.h"

namespace tribus {
namespace {

/// Keys of the device, which recorded bytes do not have.
constexpr std::array<std::string_view, 1> kDeviceKeys{"inverted"};

using Refused = tl::unexpected<std::string>;

/// Value of a text as in the configuration, but words need no quotation marks.
Value as_value(const Setting& setting, std::string_view text) {
    const bool bare = setting.type == SettingType::boolean ||
                      setting.type == SettingType::integer || setting.type == SettingType::number ||
                      setting.type == SettingType::pulse;
    Value value{.where = {}, .content = std::string(text)};
    if (bare) {
        return value_in_text(value).value_or(value);
    }
    const bool table = (setting.type == SettingType::scale || setting.type == SettingType::tree) &&
                       text.starts_with('{');
    if (table) {
        const auto document = parse_toml(fmt::format("value = {}", text));
        const Entry* const entry = document ? document->find("value") : nullptr;
        if (entry != nullptr) {
            return entry->value;
        }
    }
    return value;
}

bool applies(const Setting& setting, SettingScope direction) {
    const bool device =
        std::find(kDeviceKeys.begin(), kDeviceKeys.end(), setting.key) != kDeviceKeys.end();
    return !device && (setting.scope == SettingScope::both || setting.scope == direction);
}

const Setting* find_setting(const Protocol& protocol, SettingScope direction,
                            std::string_view key) {
    for (const Setting& setting : protocol.settings) {
        if (setting.key == key && applies(setting, direction)) {
            return &setting;
        }
    }
    return nullptr;
}

/// Whether recorded bytes of the protocol can be read, or written.
bool is_known(const Protocol& protocol, SettingScope direction) {
    return protocol.goes(direction) ||
           (direction == SettingScope::input &&
            (protocol.make_value_reader != nullptr || !protocol.has_channels()));
}

std::vector<std::string_view> known_protocols(SettingScope direction) {
    std::vector<std::string_view> names;
    for (const Protocol* protocol : protocols()) {
        if (is_known(*protocol, direction)) {
            names.push_back(protocol->name);
        }
    }
    return names;
}

/// Turns a message about a key, which begins with the quoted key or does not name it, into one
/// about an option.
std::string as_option_message(const Setting& setting, const Mistakes& mistakes) {
    const std::string option = fmt::format("--{}", setting.key);
    const std::string key = in_quotes(setting.key);
    if (mistakes.empty()) {
        return option + ": allowed: " + allowed_values({setting});
    }
    const std::string text = mistakes.sorted().front().text;
    return text.starts_with(key) ? option + text.substr(key.size()) : option + ": " + text;
}

/// The first mistake between values that are each valid, or that the protocol does not go this way;
/// else empty.
std::string mistake_between(const Protocol& protocol, SettingScope direction,
                            const SettingValues& settings) {
    if (protocol.has_channels() && !is_known(protocol, direction)) {
        const bool sends = direction == SettingScope::input;
        return fmt::format("--protocol {}: protocol {} only {}; allowed: in an {}", protocol.name,
                           in_quotes(protocol.name), sends ? "sends" : "receives",
                           sends ? "output" : "input");
    }
    if (protocol.check == nullptr) {
        return {};
    }
    const std::vector<SettingMistake> mistakes = protocol.check(settings, direction);
    if (mistakes.empty()) {
        return {};
    }
    const SettingMistake& first = mistakes.front();
    if (first.path.empty()) {
        return fmt::format("--protocol {}: {}", protocol.name, first.text);
    }
    return fmt::format("--{}: {}", fmt::join(first.path, "."), first.text);
}

/// Allowed words of a setting; empty if it allows anything else.
std::vector<std::string> allowed_words(const Setting& setting) {
    if (setting.type == SettingType::boolean) {
        return {"true", "false"};
    }
    return {setting.choices.begin(), setting.choices.end()};
}

/// What help calls the value of a setting.
std::string value_name_of(const Setting& setting) {
    switch (setting.type) {
        case SettingType::boolean:
            return "true|false";
        case SettingType::integer:
        case SettingType::number:
            return "NUMBER";
        case SettingType::text:
        case SettingType::choice:
            return "NAME";
        case SettingType::duration:
            return "DURATION";
        case SettingType::pulse:
            return "MICROSECONDS";
        case SettingType::pulses:
            return "RANGE";
        case SettingType::slew:
            return "RATE";
        case SettingType::scale:
            return "SCALE";
        case SettingType::file:
        case SettingType::key_file:
            return "FILE";
        case SettingType::tree:
            break;
    }
    return "TABLE";
}

/// Whether the name of the value does not say what is allowed.
bool has_limits(const Setting& setting) {
    return !setting.choices.empty() || setting.least != 0 || setting.most != 0;
}

/// Words on the command line have no quotation marks.
std::string without_quotes(std::string_view text) {
    std::string plain(text);
    std::erase(plain, '"');
    return plain;
}

CommandOption option_of(const Setting& setting, GivenSettings& given) {
    std::string help = without_backticks(help_with_default(setting));
    if (has_limits(setting)) {
        help += fmt::format(" ({})", without_quotes(allowed_values({setting})));
    }
    // A flag that is on by default could not be turned off by naming it.
    const bool flag = setting.type == SettingType::boolean && setting.fallback == "false";
    return {.name = fmt::format("--{}", setting.key),
            .value = [&given, key = std::string(setting.key)](
                         const std::string& text) { given.insert_or_assign(key, text); },
            .help = std::move(help),
            .value_name = flag ? std::string() : value_name_of(setting),
            .default_text = flag ? std::string() : without_quotes(setting.fallback),
            .may_stand_alone = flag,
            .offers = [words = flag ? std::vector<std::string>{}
                                    : allowed_words(setting)] { return words; }};
}

/// Adds what another protocol offers for the setting.
void add_words(CommandOption& option, const Setting& setting) {
    std::vector<std::string> all = option.offers();
    for (std::string& word : allowed_words(setting)) {
        if (std::ranges::find(all, word) == all.end()) {
            all.push_back(std::move(word));
        }
    }
    option.offers = [all = std::move(all)] { return all; };
}

}  // namespace

tl::expected<SettingValue, std::string> setting_from_text(const Setting& setting,
                                                          std::string_view text) {
    Mistakes mistakes("");
    auto value = read_value({setting}, as_value(setting, text), mistakes);
    if (!value) {
        return Refused(as_option_message(setting, mistakes));
    }
    return std::move(*value);
}

std::vector<ProtocolUse> of_shape(std::span<const ProtocolUse> uses, WireShape shape) {
    std::vector<ProtocolUse> found;
    std::ranges::copy_if(uses, std::back_inserter(found),
                         [shape](const ProtocolUse& use) { return use.protocol->shape == shape; });
    return found;
}

Duration usual_period(const ProtocolUse& use) {
    const Protocol& protocol = *use.protocol;
    const auto own =
        protocol.own_period == nullptr ? std::nullopt : protocol.own_period(use.settings);
    return own.value_or(protocol.default_period);
}

std::vector<std::string> protocol_names_on(const Medium& medium) {
    std::vector<std::string> names;
    for (const Protocol* protocol : protocols()) {
        if (carries(medium, *protocol)) {
            names.emplace_back(protocol->name);
        }
    }
    return names;
}

std::string protocol_list(const Medium& medium) {
    return fmt::format("{}", fmt::join(protocol_names_on(medium), ", "));
}

std::vector<std::string> protocol_names_for(SettingScope direction) {
    const std::vector<std::string_view> names = known_protocols(direction);
    return {names.begin(), names.end()};
}

std::string protocol_list(SettingScope direction) {
    return fmt::format("{}", fmt::join(known_protocols(direction), ", "));
}

std::vector<CommandOption> setting_options(SettingScope direction, std::string_view protocol,
                                           GivenSettings& given) {
    const Protocol* const named = find_protocol(protocol);
    std::vector<CommandOption> options;
    for (const Protocol* known : protocols()) {
        if (named != nullptr && known != named) {
            continue;
        }
        for (const Setting& setting : known->settings) {
            if (!applies(setting, direction)) {
                continue;
            }
            CommandOption option = option_of(setting, given);
            const auto same = std::ranges::find(options, option.name, &CommandOption::name);
            if (same == options.end()) {
                options.push_back(std::move(option));
            } else {
                add_words(*same, setting);
            }
        }
    }
    return options;
}

SelectedOptions settings_by_protocol(SettingScope direction, GivenSettings& given) {
    return {.by = "--protocol",
            .of =
                [direction, &given](std::string_view protocol) {
                    return setting_options(direction, protocol, given);
                },
            .knows =
                [direction](std::string_view name) {
                    const Protocol* const protocol = find_protocol(name);
                    return protocol != nullptr && is_known(*protocol, direction);
                }};
}

std::string refusal_of_key(const Protocol& protocol, const SettingValues& settings) {
    return protocol.link_with_key != nullptr && protocol.link_with_key(settings)
               ? "a link with a key is only between two programs that run: nobody else has the "
                 "challenge or the stored number that its frames need"
               : "";
}

tl::expected<ProtocolUse, std::string> use_protocol(const Protocol& protocol,
                                                    SettingScope direction,
                                                    const GivenSettings& given) {
    for (const auto& [key, text] : given) {
        if (find_setting(protocol, direction, key) == nullptr) {
            return Refused(
                fmt::format("--{}: {} has no such setting; leave it out", key, protocol.name));
        }
    }
    ProtocolUse use{.protocol = &protocol, .settings = {}, .line = protocol.line};
    for (const Setting& setting : protocol.settings) {
        if (setting.scope != SettingScope::both && setting.scope != direction) {
            continue;
        }
        const auto text = given.find(setting.key);
        if (text != given.end()) {
            auto value = setting_from_text(setting, text->second);
            if (!value) {
                return Refused(std::move(value.error()));
            }
            use.settings.set(setting.key, std::move(*value));
        } else if (!setting.fallback.empty()) {
            use.settings.set(setting.key, default_of(setting));
        } else if (setting.required && applies(setting, direction)) {
            return Refused(fmt::format("--{}: {} requires it: {}; allowed: {}", setting.key,
                                       protocol.name, without_backticks(setting.help),
                                       allowed_values({setting})));
        }
    }
    if (auto mistake = mistake_between(protocol, direction, use.settings); !mistake.empty()) {
        return Refused(std::move(mistake));
    }
    if (const auto refusal = refusal_of_key(protocol, use.settings); !refusal.empty()) {
        return Refused("--key: " + refusal);
    }
    use.line.baud =
        static_cast<std::uint32_t>(use.settings.get_or<std::int64_t>("baud", protocol.line.baud));
    return use;
}

tl::expected<std::vector<ProtocolUse>, std::string> choose_protocols(std::string_view name,
                                                                     SettingScope direction,
                                                                     const GivenSettings& given) {
    const Protocol* const named = find_protocol(name);
    if (named == nullptr && name != "auto") {
        return Refused(fmt::format("--protocol: {} is not a known protocol; {}", in_quotes(name),
                                   protocol_suggestion(name, known_protocols(direction))));
    }
    std::vector<ProtocolUse> uses;
    std::string refused;
    for (const Protocol* protocol : protocols()) {
        if (named == nullptr ? !protocol->goes(direction) : named != protocol) {
            continue;
        }
        GivenSettings own = given;
        if (named == nullptr) {
            std::erase_if(own, [&](const auto& entry) {
                return find_setting(*protocol, direction, entry.first) == nullptr;
            });
        }
        auto use = use_protocol(*protocol, direction, own);
        if (use) {
            uses.push_back(std::move(*use));
        } else if (refused.empty() || !own.empty()) {
            refused = std::move(use.error());
        }
    }
    // A setting that only a refused protocol has must not be ignored.
    const bool all_used = std::ranges::all_of(given, [&](const auto& entry) {
        return std::ranges::any_of(uses, [&](const ProtocolUse& use) {
            return find_setting(*use.protocol, direction, entry.first) != nullptr;
        });
    });
    if (uses.empty() || !all_used) {
        return Refused(std::move(refused));
    }
    return uses;
}

}  // namespace tribus
