#include "app/cli/command_line.h"

#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <functional>
#include <iterator>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <tl/expected.hpp>

#include "app/cli/exit_status.h"
#include "config/language/mistakes.h"
#include "core/quotes.h"

namespace tribus {
namespace {

constexpr std::size_t kColumns = 80;

/// Continued lines of an option are indented to its text, others like their beginning.
std::size_t indent_of(std::string_view line, std::size_t column_width) {
    const std::size_t begin = std::min(line.find_first_not_of(' '), line.size());
    constexpr std::size_t kOptionIndent = 2;
    return begin == kOptionIndent ? column_width : begin;
}

/// Returns the start of the next line: behind a blank, or behind a comma if a list of choices in
/// braces is too long for one line. npos: the line cannot be broken. `goes_on`: the line goes on
/// with such a list.
std::size_t next_line_of(const std::string& line, std::size_t indent, bool goes_on) {
    const std::size_t blank = line.rfind(' ', kColumns);
    const std::size_t word = line.find_last_not_of(' ', blank);
    if (blank != std::string::npos && word != std::string::npos && word >= indent) {
        return blank + 1;
    }
    const std::size_t comma = line.rfind(',', kColumns - 1);
    const bool in_list = goes_on || line.find('{') < comma;
    if (comma != std::string::npos && in_list && comma < line.find('}')) {
        return comma + 1;
    }
    const std::size_t late = line.find(' ', kColumns);
    return late == std::string::npos ? late : late + 1;
}

void append_broken(std::string& text, std::string line, std::size_t column_width) {
    const std::size_t indent = indent_of(line, column_width);
    bool goes_on = false;
    while (line.size() > kColumns) {
        const std::size_t next = next_line_of(line, indent, goes_on);
        if (next == std::string::npos) {
            break;
        }
        goes_on = line[next - 1] == ',';
        text += line.substr(0, line[next - 1] == ' ' ? next - 1 : next) + '\n';
        line = std::string(indent, ' ') + line.substr(next);
    }
    text += line;
}

/// Help that breaks lines at 80 columns: at blanks, and long lists of choices at commas.
class HelpFormatter : public CLI::Formatter {
  public:
    std::string make_help(const CLI::App* app, std::string name,
                          CLI::AppFormatMode mode) const override {
        const std::string whole = CLI::Formatter::make_help(app, std::move(name), mode);
        std::string text;
        for (std::size_t begin = 0; begin < whole.size();) {
            const std::size_t end = std::min(whole.find('\n', begin), whole.size());
            append_broken(text, whole.substr(begin, end - begin), column_width_);
            text += end < whole.size() ? "\n" : "";
            begin = end + 1;
        }
        return text;
    }
};

/// Number type of an option; for others the type of the value.
template <class Value>
struct NumberOf {
    using Type = Value;
};
template <class Value>
struct NumberOf<std::optional<Value>> {
    using Type = Value;
};

template <class Value>
CLI::Option* add_value(CLI::App& app, const CommandOption& option, Value* value) {
    if constexpr (std::is_same_v<Value, bool>) {
        return app.add_flag(option.name, *value, option.help);
    } else {
        CLI::Option* const added = app.add_option(option.name, *value, option.help);
        using Number = typename NumberOf<Value>::Type;
        if constexpr (std::is_arithmetic_v<Number>) {
            if (option.range) {
                added->check(CLI::Range(static_cast<Number>(option.range->first),
                                        static_cast<Number>(option.range->second)));
            }
        }
        return added;
    }
}

CLI::Option* add_value(CLI::App& app, const CommandOption& option,
                       const std::function<void(const std::string&)>& take) {
    return app.add_option_function<std::string>(option.name, take, option.help);
}

void add_option(CLI::App& app, const CommandOption& option) {
    CLI::Option* const added =
        std::visit([&](const auto& value) { return add_value(app, option, value); }, option.value);
    added->required(option.required);
    if (!option.choices.empty()) {
        added->check(CLI::IsMember(option.choices));
    }
    if (!option.type_name.empty()) {
        added->type_name(option.type_name);
    }
    if (option.shows_value) {
        added->capture_default_str();
    }
    if (!option.default_text.empty()) {
        added->default_str(option.default_text);
    }
    if (option.delimiter != 0) {
        added->delimiter(option.delimiter);
    }
    if (option.count != 0) {
        added->expected(option.count);
    }
    if (option.one_each) {
        added->allow_extra_args(false);
    }
}

/// Call it when all options of the command are added.
void join_options(CLI::App& app, const CommandOption& option) {
    CLI::Option* const added = app.get_option(option.name);
    for (const std::string& needed : option.needs) {
        added->needs(app.get_option(needed));
    }
    for (const std::string& excluded : option.excludes) {
        added->excludes(app.get_option(excluded));
    }
}

/// Only a command that is `named` gets its options: those of all commands would take half of the
/// time in which a program starts.
void add_command(CLI::App& app, const Command& command, bool named) {
    CLI::App* const added = app.add_subcommand(command.name, command.help);
    if (!named) {
        return;
    }
    for (const CommandOption& option : command.options) {
        add_option(*added, option);
    }
    for (const CommandOption& option : command.options) {
        join_options(*added, option);
    }
    added->footer(command.footer);
}

/// CLI11 would only say that a subcommand is required.
bool explain_unknown_command(std::span<const Command> commands, std::string_view word) {
    if (word.starts_with('-') ||
        std::ranges::find(commands, word, &Command::name) != commands.end()) {
        return false;
    }
    std::vector<std::string_view> names;
    std::ranges::transform(commands, std::back_inserter(names), &Command::name);
    fmt::print(stderr, "tribus: {} is not a command; {}\n", in_quotes(word),
               suggestion(word, names));
    return true;
}

/// Sets the options of the command that the words name, and returns what it does. Instead, the exit
/// status, if the words ask for help or cannot be used.
tl::expected<std::function<int()>, int> read_command_line(std::span<Command> commands,
                                                          std::string_view version, int argc,
                                                          char** argv) {
    CLI::App app{"tribus translates RC signals between i.Bus, SBUS and CAN", "tribus"};
    app.formatter(std::make_shared<HelpFormatter>());
    app.require_subcommand(1);
    app.set_version_flag("--version", std::string(version));
    const std::span words(argv, static_cast<std::size_t>(argc));
    for (const Command& command : commands) {
        const bool named =
            std::ranges::find(words, std::string_view(command.name), [](const char* word) {
                return std::string_view(word);
            }) != words.end();
        add_command(app, command, named);
    }
    if (argc <= 1) {
        fmt::print(stderr, "{}", app.help());
        return tl::unexpected(kExitWrongUse);
    }
    if (explain_unknown_command(commands, argv[1])) {
        return tl::unexpected(kExitWrongUse);
    }
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return tl::unexpected(app.exit(error) == 0 ? kExitFine : kExitWrongUse);
    }
    const auto named = std::ranges::find_if(
        commands, [&](const Command& command) { return app.got_subcommand(command.name); });
    return std::move(named->run);
}

}  // namespace

int run_command_line(std::vector<Command> commands, std::string_view version, int argc,
                     char** argv) {
    const auto run = read_command_line(commands, version, argc, argv);
    // The daemon runs for months and locks its memory; these were a quarter of a megabyte.
    commands = {};
    return run ? (*run)() : run.error();
}

std::string choices_type(std::string_view words) {
    std::string text = "TEXT:{";
    std::ranges::remove_copy(words, std::back_inserter(text), ' ');
    return text + '}';
}

}  // namespace tribus
