#include "app/cli/command_line.h"

#include <algorithm>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <iterator>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "app/cli/complain.h"
#include "app/cli/completion.h"
#include "app/cli/exit_status.h"
#include "app/cli/help_text.h"
#include "app/cli/streams.h"
#include "app/cli/wrong_use.h"
#include "app/journal/print_error.h"

namespace tribus {
namespace {

using Words = std::vector<std::string_view>;

template <class Value>
CLI::Option* add_value(CLI::App& app, const CommandOption& option, Value* value) {
    if constexpr (std::is_same_v<Value, bool>) {
        return app.add_flag(option.name, *value);
    } else {
        return app.add_option(option.name, *value);
    }
}

CLI::Option* add_value(CLI::App& app, const CommandOption& option,
                       const std::function<void(const std::string&)>& take) {
    if (option.may_stand_alone) {
        return app.add_flag_function(
            option.name, [take](std::int64_t given) { take(given > 0 ? "true" : "false"); });
    }
    return app.add_option_function<std::string>(option.name, take);
}

void add_option(CLI::App& app, const CommandOption& option) {
    CLI::Option* const added =
        std::visit([&](const auto& value) { return add_value(app, option, value); }, option.value);
    added->required(option.required);
    if (!option.flag()) {
        added->check([option](const std::string& text) { return mistake_in_value(option, text); });
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

/// `--fd true` as `--fd=true`: a flag would not take the word behind it.
std::vector<std::string> with_joined_flags(const Command* command, int argc,
                                           const char* const* argv) {
    std::vector<std::string> words(argv, argv + argc);
    if (command == nullptr || !command->selected) {
        return words;
    }
    const std::vector<CommandOption> options = command->selected->of({});
    for (std::size_t i = 1; i + 1 < words.size() && words[i] != "--"; ++i) {
        const auto option = std::ranges::find(options, words[i], &CommandOption::name);
        const bool valued = words[i + 1] == "true" || words[i + 1] == "false";
        if (option != options.end() && option->may_stand_alone && valued) {
            words[i] += "=" + words[i + 1];
            words.erase(words.begin() + static_cast<std::ptrdiff_t>(i) + 1);
        }
    }
    return words;
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
void add_command(CLI::App& app, Command& command, bool named) {
    CLI::App* const added = app.add_subcommand(command.name);
    if (!named) {
        return;
    }
    for (const CommandOption& option : command.options) {
        add_option(*added, option);
    }
    for (const CommandOption& option : command.options) {
        join_options(*added, option);
    }
    if (command.selected) {
        for (const CommandOption& option : command.selected->of({})) {
            add_option(*added, option);
        }
    }
}

/// The option that a message of CLI11 begins with; null if it begins with something else.
const CommandOption* option_of(const Command& command, std::string_view message) {
    const std::string_view name = message.substr(0, message.find_first_of(": "));
    const auto found = std::ranges::find(command.options, name, &CommandOption::name);
    return found == command.options.end() ? nullptr : &*found;
}

/// Turns what CLI11 found into a message in the words of this program. `command`: null if none is
/// named.
std::string mistake_text(const Program& program, const Command* command, const CLI::App& app,
                         const CLI::ParseError& error) {
    const std::vector<std::string> remaining = app.remaining(true);
    const auto option = std::ranges::find_if(remaining, [](const std::string& word) {
        return word.size() > 1 && word.front() == '-' && word != "--";
    });
    // The word behind an unknown option may have been taken for something else.
    if (option != remaining.end()) {
        return unknown_option(program, command, *option);
    }
    std::string message = error.what();
    if (command == nullptr) {
        return missing_word(program, command, "COMMAND");
    }
    if (dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr && !remaining.empty()) {
        return too_many_words(program, *command, remaining.front());
    }
    if (dynamic_cast<const CLI::RequiredError*>(&error) != nullptr) {
        return missing_word(program, command, message.substr(0, message.find(' ')));
    }
    if (dynamic_cast<const CLI::ExcludesError*>(&error) != nullptr) {
        const std::string_view between = " excludes ";
        const std::size_t at = message.find(between);
        return at == message.npos
                   ? message
                   : fmt::format("{} and {} do not go together", message.substr(0, at),
                                 message.substr(at + between.size()));
    }
    const CommandOption* const wrong = option_of(*command, message);
    if (dynamic_cast<const CLI::ArgumentMismatch*>(&error) != nullptr && wrong != nullptr) {
        return wrong_count(*wrong, app.get_subcommand(command->name)->count(wrong->name));
    }
    return message;
}

/// Prints help, the version or a mistake. Returns the exit status.
int end_early(const Program& program, const Command* command, const BuildFacts& built,
              const CLI::App& app, const CLI::ParseError& error, const Words& words) {
    if (dynamic_cast<const CLI::CallForVersion*>(&error) != nullptr) {
        fmt::print("{}", version_text(program.name, built));
        return kExitFine;
    }
    if (dynamic_cast<const CLI::CallForHelp*>(&error) == nullptr) {
        print_error("{}: {}\n", program.name, mistake_text(program, command, app, error));
        return kExitWrongUse;
    }
    if (command == nullptr) {
        fmt::print("{}", help_of(program));
        return kExitFine;
    }
    const std::string_view value =
        command->selected ? value_among(words, command->selected->by) : std::string_view();
    const bool selects = !value.empty() && command->selected->knows(value);
    fmt::print("{}",
               selects ? help_of_selected(program, *command, value) : help_of(program, *command));
    return kExitFine;
}

int run_words(const std::function<Program()>& make_program, const BuildFacts& built, int argc,
              char** argv) {
    Program program = make_program();
    if (argc > 1 && argv[1] == kCompletionOption) {
        fmt::print("{}", completion_text(complete(program, Words(argv + 2, argv + argc))));
        return kExitFine;
    }
    const auto run = read_command_line(program, built, argc, argv);
    // The descriptions take a quarter of a megabyte, and the daemon locks its memory.
    program = {};
    return run ? (*run)() : run.error();
}

}  // namespace

std::string_view value_among(const Words& words, std::string_view option) {
    std::string_view value;
    for (std::size_t i = 0; i < words.size(); ++i) {
        if (words[i] == option && i + 1 < words.size()) {
            value = words[i + 1];
        } else if (words[i].starts_with(option) &&
                   words[i].substr(option.size()).starts_with('=')) {
            value = words[i].substr(option.size() + 1);
        }
    }
    return value;
}

tl::expected<std::function<int()>, int> read_command_line(Program& program, const BuildFacts& built,
                                                          int argc, const char* const* argv) {
    const Words words(argv + std::min(argc, 1), argv + argc);
    if (words.empty()) {
        print_error("{}", help_of(program));
        return tl::unexpected(kExitWrongUse);
    }
    const auto named = std::ranges::find(program.commands, words.front(), &Command::name);
    if (named == program.commands.end() && !words.front().starts_with('-')) {
        print_error("{}: {}\n", program.name, unknown_command(program, words.front()));
        return tl::unexpected(kExitWrongUse);
    }
    CLI::App app{"", program.name};
    app.require_subcommand(1);
    app.set_version_flag("-V,--version", std::string(built.version));
    for (Command& command : program.commands) {
        add_command(app, command, std::ranges::find(words, command.name) != words.end());
    }
    try {
        const auto given =
            with_joined_flags(named == program.commands.end() ? nullptr : &*named, argc, argv);
        std::vector<const char*> pointers;
        std::ranges::transform(given, std::back_inserter(pointers), &std::string::c_str);
        app.parse(static_cast<int>(pointers.size()), pointers.data());
    } catch (const CLI::ParseError& error) {
        const auto got = std::ranges::find_if(program.commands, [&](const Command& command) {
            return app.got_subcommand(command.name);
        });
        const Command* const command = got == program.commands.end() ? nullptr : &*got;
        return tl::unexpected(end_early(program, command, built, app, error, words));
    }
    return std::move(std::ranges::find_if(program.commands, [&](const Command& command) {
                         return app.got_subcommand(command.name);
                     })->run);
}

int run_command_line(const std::function<Program()>& make_program, const BuildFacts& built,
                     int argc, char** argv) {
    hold_standard_streams();
    // A write beyond the limit of file sizes (RLIMIT_FSIZE) fails, as on a full disk.
    std::signal(SIGXFSZ, SIG_IGN);
    int status = kExitFailed;
    // Libraries throw when memory or standard output fails; our own code does not throw.
    try {
        status = run_words(make_program, built, argc, argv);
    } catch (const std::exception& error) {
        if (std::ferror(stdout) == 0) {
            complain(error.what(), status);
        }
    }
    return finish_standard_output(status);
}

}  // namespace tribus
