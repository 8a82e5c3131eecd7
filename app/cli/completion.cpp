#include "app/cli/completion.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <iterator>
#include <utility>

#include "app/cli/help_text.h"

namespace tribus {
namespace {

using Words = std::vector<std::string_view>;

/// Parts of a value's name that say that it is a path.
constexpr std::array<std::string_view, 6> kFileNames{"FILE",   "CONFIG", "DEVICE",
                                                     "SOCKET", "PLACE",  "INPUT"};
constexpr std::string_view kFolderName = "FOLDER";

bool names(std::string_view value_name, std::string_view part) {
    return value_name.find(part) != std::string_view::npos;
}

/// Collects the words that begin like the one at the cursor.
class Offer {
  public:
    explicit Offer(std::string_view begun) : begun_(begun) {}

    void word(std::string_view word, std::string_view meaning = {}) {
        if (word.starts_with(begun_)) {
            found_.words.push_back({std::string(word), std::string(meaning)});
        }
    }
    void values_of(const CommandOption& option) {
        for (const std::string& choice : option.choices) {
            // The shell would take two words for two values.
            const bool several = choice.find(' ') != std::string::npos;
            if (several && choice.starts_with(begun_)) {
                found_.words.push_back({"\"" + choice + "\"", ""});
            } else {
                word(several ? "\"" + choice + "\"" : choice);
            }
        }
        if (option.offers) {
            for (const std::string& offered : option.offers()) {
                word(offered);
            }
        }
        const std::string value = value_text(option);
        if (!option.choices.empty()) {
            return;
        }
        if (std::ranges::any_of(kFileNames, [&](auto part) { return names(value, part); })) {
            found_.paths = OfferedPaths::files;
        } else if (names(value, kFolderName)) {
            found_.paths = OfferedPaths::folders;
        }
    }
    Completion take() { return std::move(found_); }

  private:
    std::string_view begun_;
    Completion found_;
};

const CommandOption* find_option(const std::vector<CommandOption>& options, std::string_view name) {
    const auto found = std::ranges::find(options, name, &CommandOption::name);
    return found == options.end() || found->positional() ? nullptr : &*found;
}

std::size_t values_of_one(const CommandOption& option) {
    return option.flag() ? 0 : option.count == 0 ? 1 : static_cast<std::size_t>(option.count);
}

/// The place of the cursor.
struct CursorPlace {
    /// The option whose value stands at the cursor.
    const CommandOption* of = nullptr;
    /// How many positional arguments stand before.
    std::size_t arguments = 0;
    std::vector<const CommandOption*> given{};
    bool options_ended = false;
};

/// `before`: the words between the command and the cursor.
CursorPlace place_behind(const Words& before, const std::vector<CommandOption>& options) {
    CursorPlace place;
    std::size_t missing = 0;
    for (const std::string_view word : before) {
        if (missing > 0) {
            --missing;
            continue;
        }
        if (word == "--") {
            place.options_ended = true;
        } else if (place.options_ended || !word.starts_with('-')) {
            ++place.arguments;
        } else if (const auto* option = find_option(options, word.substr(0, word.find('=')))) {
            place.given.push_back(option);
            missing = names(word, "=") ? 0 : values_of_one(*option);
        }
    }
    place.of = missing > 0 ? place.given.back() : nullptr;
    return place;
}

/// The options of the command, with those that other words select.
std::vector<CommandOption> options_among(const Command& command, const Words& typed) {
    std::vector<CommandOption> options = command.options;
    if (command.selected) {
        auto selected = command.selected->of(value_among(typed, command.selected->by));
        std::ranges::move(selected, std::back_inserter(options));
    }
    return options;
}

void offer_options(Offer& offer, const std::vector<CommandOption>& options,
                   const CursorPlace& place) {
    for (const CommandOption& option : options) {
        const bool given = std::ranges::find(place.given, &option) != place.given.end();
        if (!option.positional() && (!given || option.repeatable())) {
            offer.word(option.name, option.help);
        }
    }
    offer.word("--help", "Show this help");
}

void offer_argument(Offer& offer, const std::vector<CommandOption>& options, std::size_t number) {
    for (const CommandOption& option : options) {
        if (!option.positional()) {
            continue;
        }
        if (number == 0 || option.repeatable()) {
            offer.values_of(option);
            return;
        }
        --number;
    }
}

Completion complete_use(const Command& command, const Words& before, std::string_view current) {
    const std::vector<CommandOption> options = options_among(command, before);
    const CursorPlace place = place_behind(before, options);
    if (place.of != nullptr) {
        Offer offer(current);
        offer.values_of(*place.of);
        return offer.take();
    }
    const std::size_t equals = current.find('=');
    if (!place.options_ended && current.starts_with("--") && equals != current.npos) {
        Offer offer(current.substr(equals + 1));
        if (const auto* option = find_option(options, current.substr(0, equals))) {
            offer.values_of(*option);
        }
        return offer.take();
    }
    Offer offer(current);
    if (!place.options_ended && current.starts_with('-')) {
        offer_options(offer, options, place);
    } else {
        offer_argument(offer, options, place.arguments);
    }
    return offer.take();
}

}  // namespace

Completion complete(const Program& program, const Words& typed) {
    const std::string_view current = typed.empty() ? std::string_view() : typed.back();
    if (typed.size() > 1) {
        const auto command = std::ranges::find(program.commands, typed.front(), &Command::name);
        return command == program.commands.end()
                   ? Completion{}
                   : complete_use(*command, Words(typed.begin() + 1, typed.end() - 1), current);
    }
    Offer offer(current);
    if (current.starts_with('-')) {
        offer.word("--help", "Show this help");
        offer.word("--version", "Show the version and how it was built");
    } else {
        for (const Command& command : program.commands) {
            offer.word(command.name, command.help);
        }
    }
    return offer.take();
}

std::string completion_text(const Completion& completion) {
    std::string text;
    for (const OfferedWord& offered : completion.words) {
        text += offered.word;
        text += offered.meaning.empty() ? "" : "\t" + offered.meaning;
        text += '\n';
    }
    switch (completion.paths) {
        case OfferedPaths::none:
            break;
        case OfferedPaths::files:
            text += ":files\n";
            break;
        case OfferedPaths::folders:
            text += ":folders\n";
            break;
    }
    return text;
}

}  // namespace tribus
