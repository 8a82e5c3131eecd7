#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "app/cli/command.h"

/// What a shell offers for the word at the cursor. The scripts of deploy/completions start the
/// program once, with `--complete` and the words typed so far, and offer what it prints.
namespace tribus {

inline constexpr std::string_view kCompletionOption = "--complete";

/// A word that fits, and what it means.
struct OfferedWord {
    std::string word;
    std::string meaning{};
};

/// The paths that the shell itself offers besides.
enum class OfferedPaths : unsigned char { none, files, folders };

struct Completion {
    std::vector<OfferedWord> words;
    OfferedPaths paths = OfferedPaths::none;
};

/// `typed`: the words behind the program's name, up to the cursor; the last one may be empty. Words
/// for `--option=` are values without the option. May ask which daemons run, by `offers`.
Completion complete(const Program& program, const std::vector<std::string_view>& typed);

/// A line for each word, `WORD` or `WORD<tab>meaning`; a last line `:files` or `:folders` asks for
/// paths. Pure.
std::string completion_text(const Completion& completion);

}  // namespace tribus
