#pragma once

#include <array>
#include <cstddef>
#include <ostream>
#include <regex>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "config/load.h"
#include "transports/registry/registry.h"

namespace tribus::test {

/// A valid configuration of nine lines. Each test changes one of them.
inline constexpr std::array<std::string_view, 9> kMainJob{
    "[input.receiver]", "protocol = \"ibus\"", "device = \"/dev/ttyA\"",
    "[output.servos]",  "protocol = \"sbus\"", "device = \"/dev/ttyB\"",
    "[pipeline.main]",  "from = \"receiver\"", "to = \"servos\"",
};

/// Returns the nine lines with another text for line `number`, counted from 1. With number 10 the
/// text is added after them.
inline std::string main_job_with(std::size_t number, std::string_view replacement) {
    std::string text;
    for (std::size_t i = 0; i < kMainJob.size(); ++i) {
        text += i + 1 == number ? replacement : kMainJob[i];
        text += '\n';
    }
    return number == kMainJob.size() + 1 ? text + std::string(replacement) + "\n" : text;
}

/// Tables of a valid configuration from SBUS to SBUS, in any order.
inline constexpr std::string_view kReceiverTable = R"([input.receiver]
protocol = "sbus"
device = "/dev/ttyA"
)";
inline constexpr std::string_view kServosTable = R"([output.servos]
protocol = "sbus"
device = "/dev/ttyB"
)";
inline constexpr std::string_view kPipelineTable = R"([pipeline.main]
from = "receiver"
to = "servos"
)";

/// Returns the mistakes as a user sees them; empty if the text is a valid configuration.
inline std::vector<std::string> mistakes_in(std::string_view text,
                                            std::string_view file_name = "t.toml") {
    std::vector<std::string> lines;
    const auto configuration = load_configuration(text, file_name);
    if (!configuration) {
        for (const Mistake& mistake : configuration.error()) {
            lines.push_back(format_mistake(mistake));
        }
    }
    return lines;
}

/// `; or "KEY": HELP` for each medium that carries that protocol, but the usual one.
inline std::string other_places(std::string_view protocol = "ibus") {
    std::string places;
    for (const Medium* medium : media_for(*find_protocol(protocol))) {
        const std::string key(medium->place.key);
        places += key == "device" ? "" : "; or \"" + key + "\": " + std::string(medium->place.help);
    }
    return places;
}

/// `"ibus", "sbus", ...`: all protocols that go that way, in the order of the registry.
inline std::string protocols_in_quotes(SettingScope way) {
    std::string list;
    for (const Protocol* protocol : protocols()) {
        if (protocol->goes(way)) {
            list += (list.empty() ? "\"" : ", \"") + std::string(protocol->name) + "\"";
        }
    }
    return list;
}

/// INPUTS and OUTPUTS stand for the protocols of that way, OTHER_PLACES for the keys of further
/// media that carry i.Bus.
inline std::string written_out(std::string text) {
    text = std::regex_replace(text, std::regex("OTHER_PLACES"), other_places());
    text = std::regex_replace(text, std::regex("INPUTS"), protocols_in_quotes(SettingScope::input));
    return std::regex_replace(text, std::regex("OUTPUTS"),
                              protocols_in_quotes(SettingScope::output));
}

/// Loads a text that must be a valid configuration.
inline Configuration loaded(std::string_view text) {
    auto configuration = load_configuration(text, "t.toml");
    if (!configuration) {
        ADD_FAILURE() << format_mistake(configuration.error().front());
        return {};
    }
    return std::move(*configuration);
}

/// A change of one of the nine lines, and the one message that a user must see.
struct Spoilt {
    std::string_view name;
    std::size_t line;
    std::string_view replacement;
    std::string_view expected;
};

inline std::ostream& operator<<(std::ostream& out, const Spoilt& spoilt) {
    return out << spoilt.name;
}

}  // namespace tribus::test
