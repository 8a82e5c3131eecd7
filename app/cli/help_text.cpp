#include "app/cli/help_text.h"

#include <algorithm>
#include <array>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "app/cli/exit_status.h"
#include "config/show/paragraph.h"

namespace tribus {
namespace {

constexpr std::size_t kHelpColumns = 80;
/// The widest name of an option beside which its text begins; wider ones have a line of their own.
constexpr std::size_t kWidestName = 24;
/// Choices that are wider stand in the text of the option.
constexpr std::size_t kWidestChoices = 20;
constexpr std::string_view kIndent = "  ";

/// What help says of the statuses, unless a command says otherwise.
constexpr std::array kUsualExits{
    ExitMeaning{kExitFine, "fine"},
    ExitMeaning{kExitFailed, "the work failed: a device, a bus, a file, a daemon that is away"},
    ExitMeaning{kExitWrongUse, "wrong use, or a configuration with mistakes"}};

/// A name and what it means, in two columns.
struct HelpRow {
    std::string name;
    std::string text;
};

/// The stored value as text; empty for a flag and for what is not set.
struct StoredText {
    std::string operator()(const bool* /*flag*/) const { return {}; }
    std::string operator()(const std::string* text) const { return *text; }
    std::string operator()(const std::vector<std::string>* texts) const {
        return fmt::format("{}", fmt::join(*texts, ","));
    }
    std::string operator()(const std::function<void(const std::string&)>& /*take*/) const {
        return {};
    }
    template <class Value>
    std::string operator()(const std::optional<Value>* value) const {
        return *value ? fmt::format("{}", **value) : std::string();
    }
    template <class Number>
    requires std::is_arithmetic_v<Number> std::string operator()(const Number* number) const {
        return fmt::format("{}", *number);
    }
};

std::string choices_in_name(const CommandOption& option) {
    std::string words = fmt::format("{}", fmt::join(option.choices, "|"));
    return words.size() <= kWidestChoices ? words : std::string();
}

std::string text_of(const CommandOption& option) {
    std::string text = option.help;
    const auto add = [&text](const std::string& more) { text += "; " + more; };
    if (!option.choices.empty() && choices_in_name(option).empty()) {
        add(fmt::format("{}", fmt::join(option.choices, ", ")));
    }
    if (option.range) {
        add(fmt::format("{} to {}", option.range->first, option.range->second));
    }
    const std::string fallback = option.shows_value && option.default_text.empty()
                                     ? std::visit(StoredText{}, option.value)
                                     : option.default_text;
    if (!fallback.empty()) {
        add("default: " + fallback);
    }
    if (option.repeatable() && option.delimiter == 0 && !option.positional()) {
        add("may be repeated");
    }
    if (!option.needs.empty()) {
        add(fmt::format("only with {}", fmt::join(option.needs, " and ")));
    }
    if (!option.excludes.empty()) {
        add(fmt::format("not with {}", fmt::join(option.excludes, " or ")));
    }
    return text;
}

HelpRow row_of(const CommandOption& option) {
    const std::string value = value_text(option);
    return {option.positional() || value.empty() ? option.name : option.name + " " + value,
            text_of(option)};
}

std::string rows_text(std::span<const HelpRow> rows) {
    std::size_t width = 0;
    for (const HelpRow& row : rows) {
        width = std::max(width, row.name.size() <= kWidestName ? row.name.size() : 0);
    }
    const std::string rest(kIndent.size() + width + kIndent.size(), ' ');
    std::string text;
    for (const HelpRow& row : rows) {
        std::string first = fmt::format("{}{:<{}}{}", kIndent, row.name, width, kIndent);
        if (row.name.size() > width) {
            text += fmt::format("{}{}\n", kIndent, row.name);
            first = rest;
        }
        text += paragraph(first, rest, row.text, kHelpColumns);
    }
    return text;
}

/// Paragraphs, and rows of tables, which begin with blanks.
std::string notes_text(std::string_view notes) {
    std::string text;
    while (!notes.empty()) {
        const std::size_t end = std::min(notes.find('\n'), notes.size());
        const std::string_view line = notes.substr(0, end);
        notes.remove_prefix(std::min(end + 1, notes.size()));
        const std::size_t word = std::min(line.find_first_not_of(' '), line.size());
        const std::size_t gap = word == 0 ? line.npos : line.find(kIndent, word);
        const std::size_t begin = gap == line.npos ? word : line.find_first_not_of(' ', gap);
        text += paragraph(line.substr(0, begin), std::string(begin, ' '), line.substr(begin),
                          kHelpColumns);
    }
    return text;
}

std::string examples_text(std::span<const CommandExample> examples) {
    std::string text = examples.empty() ? "" : "\nExamples:\n";
    for (const CommandExample& example : examples) {
        text += fmt::format("{}{}\n", kIndent, example.line);
        if (!example.purpose.empty()) {
            text += paragraph("      ", "      ", example.purpose, kHelpColumns);
        }
    }
    return text;
}

std::string exits_text(std::span<const ExitMeaning> own) {
    std::vector<ExitMeaning> all(own.begin(), own.end());
    for (const ExitMeaning& usual : kUsualExits) {
        if (std::ranges::find(own, usual.status, &ExitMeaning::status) == own.end()) {
            all.push_back(usual);
        }
    }
    std::ranges::sort(all, {}, &ExitMeaning::status);
    std::vector<HelpRow> rows;
    rows.reserve(all.size());
    for (const ExitMeaning& exit : all) {
        rows.push_back({fmt::format("{}", exit.status), std::string(exit.meaning)});
    }
    return "\nExit status:\n" + rows_text(rows);
}

std::string sentence(const std::string& text) {
    return paragraph("", "", text + ".", kHelpColumns);
}

}  // namespace

std::string value_text(const CommandOption& option) {
    if (option.flag()) {
        return {};
    }
    std::string choices = choices_in_name(option);
    if (!choices.empty()) {
        return choices;
    }
    return option.value_name.empty() && option.positional() ? option.name : option.value_name;
}

std::string usage_of(const Program& program, const Command& command, std::string_view given) {
    std::string text = fmt::format("{} {}", program.name, command.name);
    text += given.empty() ? "" : fmt::format(" {}", given);
    for (const CommandOption& option : command.options) {
        if (!option.positional() && option.required) {
            text += fmt::format(" {} {}", option.name, value_text(option));
        }
    }
    text += " [OPTIONS]";
    for (const CommandOption& option : command.options) {
        if (option.positional()) {
            const std::string name = option.name + (option.repeatable() ? "..." : "");
            text += " " + (option.required ? name : "[" + name + "]");
        }
    }
    return text;
}

std::string help_of(const Program& program) {
    std::vector<HelpRow> commands;
    for (const Command& command : program.commands) {
        commands.push_back({command.name, command.help});
    }
    const std::vector<HelpRow> options{{"-h, --help", "Show this help"},
                                       {"-V, --version", "Show the version and how it was built"}};
    return fmt::format(
        "Usage: {0} COMMAND [OPTIONS] [ARGUMENTS]\n\n{1}\nCommands:\n{2}\n"
        "`{0} COMMAND --help` says more of each.\n\nOptions:\n{3}{4}{5}",
        program.name, sentence(program.help), rows_text(commands), rows_text(options),
        examples_text(program.examples), exits_text({}));
}

std::string help_of(const Program& program, const Command& command) {
    std::vector<HelpRow> arguments;
    std::vector<HelpRow> options;
    for (const CommandOption& option : command.options) {
        (option.positional() ? arguments : options).push_back(row_of(option));
    }
    options.push_back({"-h, --help", "Show this help"});
    std::string text = "Usage: " + usage_of(program, command) + "\n\n" + sentence(command.help);
    text += arguments.empty() ? "" : "\nArguments:\n" + rows_text(arguments);
    text += "\nOptions:\n" + rows_text(options);
    text += command.notes.empty() ? "" : "\n" + notes_text(command.notes);
    return text + examples_text(command.examples) + exits_text(command.exits);
}

std::string help_of_selected(const Program& program, const Command& command,
                             std::string_view value) {
    const SelectedOptions& selected = command.selected.value();
    std::vector<HelpRow> options;
    for (const CommandOption& option : selected.of(value)) {
        options.push_back(row_of(option));
    }
    return fmt::format("Usage: {}\n\n{}{}\n`{} {} --help` shows the other options and examples.\n",
                       usage_of(program, command, fmt::format("{} {}", selected.by, value)),
                       options.empty() ? fmt::format("{} has no options of its own.\n", value)
                                       : fmt::format("Options of {}:\n", value),
                       rows_text(options), program.name, command.name);
}

}  // namespace tribus
