#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

/// What the command line of the program consists of, without the library that reads it.
namespace tribus {

/// Where the value of an option goes. A bool is a flag; a function gets each value as it was typed.
using OptionValue =
    std::variant<bool*, std::string*, std::optional<std::string>*, std::vector<std::string>*, int*,
                 std::uint64_t*, std::optional<std::int64_t>*, double*, std::optional<double>*,
                 std::function<void(const std::string&)>>;

/// One option of a command, or one of its words without dashes.
struct CommandOption {
    /// `--format`, or for a word without dashes `CONFIG`.
    std::string name;
    OptionValue value;
    std::string help;
    bool required = false;
    /// Help shows the value that stands there before the command line is read.
    bool shows_value = false;
    /// Allowed words; empty: any.
    std::vector<std::string> choices{};
    /// Least and highest number that is allowed.
    std::optional<std::pair<double, double>> range{};
    /// What help shows in the place of the value's type.
    std::string type_name{};
    /// What help shows as the default where the value itself does not say it.
    std::string default_text{};
    /// Values in one word are separated by it; 0: one value a word.
    char delimiter = 0;
    /// How many values follow; 0: what the type of the value says.
    int count = 0;
    /// Options of the same command that must be there too, and that must not.
    std::vector<std::string> needs{};
    std::vector<std::string> excludes{};
};

/// One command of the program.
struct Command {
    std::string name;
    std::string help;
    std::string footer{};
    /// In the order in which help shows them. What they point to lives as long as `run`.
    std::vector<CommandOption> options{};
    /// Does the work once the options are read; returns the exit status. May block.
    std::function<int()> run{};
};

}  // namespace tribus
