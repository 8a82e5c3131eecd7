#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

/// The command line of the program, described without the library that reads it.
namespace tribus {

/// Target of the value of an option. A bool is a flag; a function gets each value as text.
using OptionValue =
    std::variant<bool*, std::string*, std::optional<std::string>*, std::vector<std::string>*, int*,
                 std::uint64_t*, std::optional<std::int64_t>*, double*, std::optional<double>*,
                 std::function<void(const std::string&)>>;

/// One option of a command, or a positional argument.
struct CommandOption {
    /// `--format`, or `CONFIG` for a positional argument.
    std::string name;
    OptionValue value;
    std::string help;
    bool required = false;
    /// Help shows the stored value as the default.
    bool shows_value = false;
    /// Allowed words; empty: any.
    std::vector<std::string> choices{};
    /// Smallest and largest allowed number.
    std::optional<std::pair<double, double>> range{};
    /// Shown in help instead of the type of the value.
    std::string type_name{};
    /// Default shown in help, if the stored value does not show it.
    std::string default_text{};
    /// Separates several values in one argument; 0: one value an argument.
    char delimiter = 0;
    /// Number of values that follow; 0: as the type of the value says.
    int count = 0;
    /// A list takes one value each time the option is given, not all words that follow it.
    bool one_each = false;
    /// Other options of this command that it requires, and that it excludes.
    std::vector<std::string> needs{};
    std::vector<std::string> excludes{};
};

/// One command of the program.
struct Command {
    std::string name;
    std::string help;
    std::string footer{};
    /// In the order in which help shows them. Their targets live as long as `run`.
    std::vector<CommandOption> options{};
    /// Does the work after the options are read; returns the exit status. May block.
    std::function<int()> run{};
};

}  // namespace tribus
