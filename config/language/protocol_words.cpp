#include "config/language/protocol_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <iterator>

#include "config/language/mistakes.h"
#include "core/quotes.h"

namespace tribus {
namespace {

constexpr std::array kProtocolWords{
    // Makers, their products and what they call their links.
    ProtocolWord{"elrs", {"crsf"}},
    ProtocolWord{"expresslrs", {"crsf"}},
    ProtocolWord{"crossfire", {"crsf"}},
    ProtocolWord{"tracer", {"crsf"}},
    ProtocolWord{"tbs", {"crsf"}},
    ProtocolWord{"mlrs", {"crsf", "mavlink"}},
    ProtocolWord{"radiomaster", {"crsf", "sbus"}},
    ProtocolWord{"betafpv", {"crsf"}},
    ProtocolWord{"happymodel", {"crsf"}},
    ProtocolWord{"flysky", {"ibus", "ibus2"}},
    ProtocolWord{"fsi", {"ibus"}},
    ProtocolWord{"fsx", {"ibus"}},
    ProtocolWord{"afhds3", {"ibus2", "ibus"}},
    ProtocolWord{"afhds", {"ibus"}},
    ProtocolWord{"turnigy", {"ibus"}},
    ProtocolWord{"spektrum", {"dsm", "srxl"}},
    ProtocolWord{"dsm", {"dsm"}},
    ProtocolWord{"orangerx", {"dsm"}},
    ProtocolWord{"futaba", {"sbus"}},
    ProtocolWord{"fasst", {"sbus"}},
    ProtocolWord{"fhss", {"sbus"}},
    ProtocolWord{"frsky", {"sbus", "fport", "fbus"}},
    ProtocolWord{"archer", {"fbus", "fport", "sbus"}},
    ProtocolWord{"graupner", {"sumd"}},
    ProtocolWord{"hott", {"sumd"}},
    ProtocolWord{"jeti", {"exbus"}},
    ProtocolWord{"duplex", {"exbus"}},
    ProtocolWord{"multiplex", {"srxl"}},
    ProtocolWord{"jr", {"srxl"}},
    ProtocolWord{"immersionrc", {"ghst"}},
    ProtocolWord{"ghost", {"ghst"}},
    ProtocolWord{"ardupilot", {"mavlink", "dronecan"}},
    ProtocolWord{"pixhawk", {"mavlink", "dronecan"}},
    ProtocolWord{"px4", {"mavlink", "dronecan"}},
    ProtocolWord{"qgroundcontrol", {"mavlink"}},
    ProtocolWord{"missionplanner", {"mavlink"}},
    ProtocolWord{"betaflight", {"msp", "sbus", "crsf"}},
    ProtocolWord{"inav", {"msp", "sbus", "crsf"}},
    ProtocolWord{"multiwii", {"msp"}},
    ProtocolWord{"gazebo", {"sitl"}},
    ProtocolWord{"simulator", {"sitl", "joystick"}},
    ProtocolWord{"xbox", {"gamepad"}},
    ProtocolWord{"playstation", {"gamepad"}},
    ProtocolWord{"dualshock", {"gamepad"}},
    ProtocolWord{"dualsense", {"gamepad"}},
    ProtocolWord{"ps3", {"gamepad"}},
    ProtocolWord{"ps4", {"gamepad"}},
    ProtocolWord{"ps5", {"gamepad"}},
    ProtocolWord{"evdev", {"gamepad"}},
    ProtocolWord{"uinput", {"joystick"}},
    ProtocolWord{"pca9685", {"pwm"}},
    ProtocolWord{"servo", {"pwm"}},
    // Other names.
    ProtocolWord{"cppm", {"ppm"}},
    ProtocolWord{"ppmsum", {"ppm"}},
    ProtocolWord{"trainer", {"ppm"}},
    ProtocolWord{"uavcan", {"dronecan"}},
    ProtocolWord{"socketcan", {"can"}},
    ProtocolWord{"j1939", {"dbc"}},
    ProtocolWord{"canopen", {"dbc"}},
    ProtocolWord{"udp", {"network"}},
    // What the other direction has instead.
    ProtocolWord{"joystick", {"gamepad"}},
    ProtocolWord{"gamepad", {"joystick"}},
    ProtocolWord{"pwm", {"ppm"}},
    ProtocolWord{"ibus2", {"ibus"}},
    ProtocolWord{"fport", {"sbus"}},
    ProtocolWord{"fbus", {"sbus"}},
};

std::string joined_by_or(std::span<const std::string_view> names) {
    const std::string last = in_quotes(names.back());
    return names.size() == 1
               ? last
               : fmt::format("{} or {}", in_quotes_all(names.first(names.size() - 1)), last);
}

}  // namespace

std::string small_letters_and_digits(std::string_view text) {
    std::string plain;
    for (const char c : text) {
        if (std::isalnum(static_cast<unsigned char>(c)) != 0) {
            plain += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
        }
    }
    return plain;
}

std::span<const ProtocolWord> protocol_words() {
    return kProtocolWords;
}

std::vector<std::string_view> protocols_meant(std::string_view word,
                                              std::span<const std::string_view> allowed) {
    std::vector<std::string_view> meant;
    const std::string plain = small_letters_and_digits(word);
    const auto same = std::ranges::find(allowed, plain, small_letters_and_digits);
    if (same != allowed.end()) {
        return {*same};
    }
    const auto known = std::ranges::find_if(
        kProtocolWords, [&plain](const ProtocolWord& row) { return plain.starts_with(row.word); });
    if (known == kProtocolWords.end()) {
        return meant;
    }
    std::ranges::copy_if(known->protocols, std::back_inserter(meant), [&](std::string_view name) {
        return std::ranges::find(allowed, name) != allowed.end();
    });
    return meant;
}

std::string protocol_suggestion(std::string_view wrong, std::span<const std::string_view> allowed) {
    const auto meant = protocols_meant(wrong, allowed);
    return meant.empty() ? suggestion(wrong, allowed)
                         : fmt::format("did you mean {}? Allowed: {}", joined_by_or(meant),
                                       in_quotes_all(allowed));
}

}  // namespace tribus
