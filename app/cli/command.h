#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

/// The command line of a program, described without the library that reads it.
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
    /// What help calls the value: `FILE`, `NAME=FILE`. Needed by options that have a value and no
    /// choices. Where it names a file or a folder, completion offers those.
    std::string value_name{};
    /// Default shown in help, if the stored value does not show it.
    std::string default_text{};
    /// Separates several values in one argument; 0: one value an argument.
    char delimiter = 0;
    /// Number of values that follow; 0: as the type of the value says.
    int count = 0;
    /// A list takes one value each time the option is given, not all words that follow it.
    bool one_each = false;
    /// A function is called with "true" where the option stands alone: it is a flag, which may also
    /// have the value `true` or `false`.
    bool may_stand_alone = false;
    /// Other options of this command that it requires, and that it excludes.
    std::vector<std::string> needs{};
    std::vector<std::string> excludes{};
    /// Words that completion offers besides the choices, such as the names of running daemons.
    std::function<std::vector<std::string>()> offers{};

    bool positional() const { return !name.starts_with('-'); }
    bool flag() const { return may_stand_alone || std::holds_alternative<bool*>(value); }
    /// Whether it may be given several times.
    bool repeatable() const {
        return std::holds_alternative<std::vector<std::string>*>(value) && count == 0;
    }
};

/// A command line that help shows, and what it is for. The text has static storage.
struct CommandExample {
    std::string_view line;
    std::string_view purpose;
};

/// Meaning of an exit status of one command. The text has static storage.
struct ExitMeaning {
    int status;
    std::string_view meaning;
};

/// Options of which each value of another option has its own, such as the settings of a protocol.
struct SelectedOptions {
    /// `--protocol`
    std::string_view by;
    /// The options for a value; for any other text those for all values, each name once.
    std::function<std::vector<CommandOption>(std::string_view value)> of;
    /// Whether there are options for the value.
    std::function<bool(std::string_view value)> knows;
};

/// One command of a program.
struct Command {
    std::string name;
    std::string help;
    /// Shown behind the options. A line that begins with blanks is a row of a table: a word, and
    /// behind at least two blanks its text.
    std::string notes{};
    /// In the order in which help shows them. Their targets live as long as `run`.
    std::vector<CommandOption> options{};
    std::vector<CommandExample> examples{};
    /// Statuses that mean something else here than what `kUsualExits` says.
    std::vector<ExitMeaning> exits{};
    std::optional<SelectedOptions> selected{};
    /// Does the work after the options are read; returns the exit status. May block.
    std::function<int()> run{};
};

/// A program with its commands, in the order in which help lists them.
struct Program {
    std::string name;
    std::string help;
    std::vector<Command> commands;
    std::vector<CommandExample> examples{};
};

/// The value that the words of a command line give an option, as `--name VALUE` or `--name=VALUE`;
/// the last one counts. Empty: none.
std::string_view value_among(const std::vector<std::string_view>& words, std::string_view option);

}  // namespace tribus
