#include "app/cli/wrong_use.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <optional>
#include <type_traits>
#include <vector>

#include <fmt/format.h>

#include "app/cli/help_text.h"
#include "config/language/mistakes.h"
#include "config/language/nearest.h"
#include "core/quotes.h"

namespace tribus {
namespace {

/// `tribus check`, or `tribus` without a command.
std::string name_of_use(const Program& program, const Command* command) {
    return command == nullptr ? program.name : program.name + " " + command->name;
}

/// Whether the target is a number, and whether it must be a whole one.
struct NumberKind {
    bool number = false;
    bool whole = false;
};

template <class Value>
struct NumberOf {
    using Type = Value;
};
template <class Value>
struct NumberOf<std::optional<Value>> {
    using Type = Value;
};

NumberKind number_kind(const OptionValue& value) {
    return std::visit(
        [](const auto& target) -> NumberKind {
            using Target = std::remove_pointer_t<std::decay_t<decltype(target)>>;
            using Number = typename NumberOf<Target>::Type;
            return {std::is_arithmetic_v<Number> && !std::is_same_v<Number, bool>,
                    std::is_integral_v<Number>};
        },
        value);
}

/// Whole numbers may be hexadecimal, as in the configuration.
std::optional<double> number_in(const std::string& text, bool whole) {
    char* end = nullptr;
    errno = 0;
    const double number = whole ? static_cast<double>(std::strtoll(text.c_str(), &end, 0))
                                : std::strtod(text.c_str(), &end);
    const bool all = !text.empty() && end == text.c_str() + text.size();
    return all && errno == 0 && std::isfinite(number) ? std::optional(number) : std::nullopt;
}

}  // namespace

std::string unknown_command(const Program& program, std::string_view word) {
    std::vector<std::string_view> names;
    std::ranges::transform(program.commands, std::back_inserter(names), &Command::name);
    return fmt::format("{} is not a command; {}", in_quotes(word), suggestion(word, names));
}

std::string unknown_option(const Program& program, const Command* command, std::string_view word) {
    std::vector<std::string> names{"help"};
    const auto add = [&names](const std::vector<CommandOption>& options) {
        for (const CommandOption& option : options) {
            if (!option.positional()) {
                names.push_back(option.name.substr(2));
            }
        }
    };
    if (command == nullptr) {
        names.emplace_back("version");
    } else {
        add(command->options);
        if (command->selected) {
            add(command->selected->of({}));
        }
    }
    const std::string_view name = word.substr(0, word.find('='));
    const std::string_view bare = name.substr(std::min(name.find_first_not_of('-'), name.size()));
    const auto near = nearest(bare, std::vector<std::string_view>(names.begin(), names.end()));
    const std::string use = name_of_use(program, command);
    return fmt::format("{} is not an option of {}; {}`{} --help` lists them", name, use,
                       near ? fmt::format("did you mean --{}? ", *near) : std::string(), use);
}

std::string too_many_words(const Program& program, const Command& command, std::string_view word) {
    return fmt::format("{} is one word too many; usage: {}", in_quotes(word),
                       usage_of(program, command));
}

std::string missing_word(const Program& program, const Command* command, std::string_view name) {
    if (command == nullptr) {
        return fmt::format("a command is missing; `{} --help` lists them", program.name);
    }
    return fmt::format("{} is missing; usage: {}", name, usage_of(program, *command));
}

std::string wrong_count(const CommandOption& option, std::size_t times) {
    if (option.flag()) {
        return option.name + " takes no value";
    }
    if (times > 1 && option.count == 0) {
        return option.name + " is given several times; allowed: once";
    }
    const std::string values =
        option.count > 1 ? fmt::format("{} values", option.count) : "a value";
    return fmt::format("{} needs {}: {}", option.name, values, value_text(option));
}

std::string mistake_in_value(const CommandOption& option, const std::string& text) {
    if (!option.choices.empty()) {
        const std::vector<std::string_view> allowed(option.choices.begin(), option.choices.end());
        return std::ranges::find(allowed, text) != allowed.end()
                   ? std::string()
                   : fmt::format("{} is not known; {}", in_quotes(text), suggestion(text, allowed));
    }
    const NumberKind kind = number_kind(option.value);
    if (!kind.number) {
        return {};
    }
    const auto number = number_in(text, kind.whole);
    const bool within =
        number &&
        (!option.range || (*number >= option.range->first && *number <= option.range->second));
    if (within) {
        return {};
    }
    return fmt::format(
        "{} is not possible; allowed: a {}{}", in_quotes(text),
        kind.whole ? "whole number" : "number",
        option.range ? fmt::format(" from {} to {}", option.range->first, option.range->second)
                     : std::string());
}

}  // namespace tribus
