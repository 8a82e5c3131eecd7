#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "transports/codecs/joystick/joystick.h"
#include "transports/codecs/setting_tables.h"

namespace tribus {
namespace {

constexpr std::array kJoystickKeys{
    Setting{
        .key = "axes",
        .type = SettingType::tree,
        .absent = "channels 1 to 8, in this order",
        .scope = SettingScope::output,
        .help =
            "The channel of each axis: `ABS_X`, `ABS_Y`, `ABS_Z`, `ABS_RX`, `ABS_RY`, "
            "`ABS_RZ`, `ABS_THROTTLE`, `ABS_RUDDER`. An axis without a channel stays in its centre",
        .example = "{ ABS_X = 1, ABS_Y = 2, ABS_Z = 3, ABS_RX = 4 }"},
    Setting{.key = "buttons",
            .type = SettingType::tree,
            .absent = "channels 9 to 18, in this order",
            .scope = SettingScope::output,
            .help = "The channel of each button, 1 to 24, pressed above 1500 us; or a table with "
                    "`channel` and `above`, `below` or `between`, for a switch of three positions",
            .example = "{ 1 = 5, 2 = { channel = 6, below = 1300 }, 3 = { channel = 6, between = "
                       "[1300, 1700] } }"},
    Setting{.key = "throttle",
            .type = SettingType::integer,
            .fallback = "3",
            .least = 1,
            .most = kChannelCount,
            .scope = SettingScope::output,
            .help = "The channel whose axis goes to its lowest when the output falls silent; the "
                    "others go to their centre",
            .example = "3"},
};

/// Channels 1 to 8, in this order.
SettingTree::Table usual_joystick_axes() {
    SettingTree::Table axes;
    for (const std::string_view name : kJoystickAxes) {
        axes.push_back(channel_entry(name, axes.size()));
    }
    return axes;
}

/// Channels 9 to 18, in this order.
SettingTree::Table usual_joystick_buttons() {
    SettingTree::Table buttons;
    for (std::size_t channel = kJoystickAxes.size(); channel < kChannelCount; ++channel) {
        buttons.push_back(channel_entry(std::to_string(buttons.size() + 1), channel));
    }
    return buttons;
}

SettingValues joystick_defaults(const SettingValues& /*settings*/, SettingScope /*way*/) {
    SettingValues defaults;
    defaults.set("axes", SettingTree{usual_joystick_axes()});
    defaults.set("buttons", SettingTree{usual_joystick_buttons()});
    return defaults;
}

using JoystickPath = std::vector<std::string>;

/// Reads the tables of axes and buttons, and collects mistakes.
class JoystickReader {
  public:
    JoystickReader(const SettingValues& settings, std::vector<SettingMistake>& mistakes)
        : settings_(settings), mistakes_(mistakes) {}

    JoystickSettings read() {
        JoystickSettings joystick;
        read_axes(joystick);
        read_buttons(joystick);
        joystick.throttle =
            static_cast<std::size_t>(settings_.get_or<std::int64_t>("throttle", 3)) - 1;
        return joystick;
    }

  private:
    void wrong(JoystickPath path, std::string text) {
        mistakes_.push_back({std::move(path), std::move(text)});
    }

    std::optional<std::size_t> channel_in(const SettingTree& tree, const JoystickPath& path) {
        const auto channel = channel_of(tree);
        if (!channel) {
            wrong(path, "allowed: a channel, 1 to 18");
        }
        return channel;
    }

    void read_axes(JoystickSettings& joystick) {
        const auto* entries = table_of(settings_, "axes");
        for (const SettingEntry& entry : entries == nullptr ? usual_joystick_axes() : *entries) {
            const auto name = std::ranges::find(kJoystickAxes, entry.key);
            if (name == kJoystickAxes.end()) {
                wrong(
                    {"axes", entry.key},
                    "unknown; allowed: ABS_X, ABS_Y, ABS_Z, ABS_RX, ABS_RY, ABS_RZ, ABS_THROTTLE, "
                    "ABS_RUDDER");
                continue;
            }
            joystick.axes[static_cast<std::size_t>(name - kJoystickAxes.begin())] =
                channel_in(entry.value, {"axes", entry.key});
        }
    }

    void read_buttons(JoystickSettings& joystick) {
        const auto* entries = table_of(settings_, "buttons");
        for (const SettingEntry& entry : entries == nullptr ? usual_joystick_buttons() : *entries) {
            const JoystickPath path{"buttons", entry.key};
            const std::size_t number = std::strtoul(entry.key.c_str(), nullptr, 10);
            if (number < 1 || number > kJoystickButtons || std::to_string(number) != entry.key) {
                wrong(path, "unknown; allowed: buttons 1 to 24");
            } else if (auto button = read_button(entry.value, path)) {
                button->button = number - 1;
                joystick.buttons.push_back(*button);
            }
        }
    }

    std::optional<JoystickButton> read_button(const SettingTree& tree, const JoystickPath& path) {
        JoystickButton button;
        const auto* entries = tree.as<SettingTree::Table>();
        if (entries == nullptr) {
            const auto channel = channel_in(tree, path);
            button.channel = channel.value_or(0);
            button.above = kCentrePulse;
            return channel ? std::optional(button) : std::nullopt;
        }
        std::optional<std::size_t> channel;
        for (const SettingEntry& entry : *entries) {
            const JoystickPath inside{path[0], path[1], entry.key};
            if (entry.key == "channel") {
                channel = channel_in(entry.value, inside);
            } else if (entry.key == "above") {
                button.above = pulse_in(entry.value, inside);
            } else if (entry.key == "below") {
                button.below = pulse_in(entry.value, inside);
            } else if (entry.key == "between") {
                button.between = range_in(entry.value, inside);
            } else {
                wrong(inside, "unknown; allowed: channel, above, below, between");
            }
        }
        if (!channel || !(button.above || button.below || button.between)) {
            wrong(path, "allowed: a channel, or a table with channel and above, below or between");
            return std::nullopt;
        }
        button.channel = *channel;
        return button;
    }

    std::optional<Pulse> pulse_in(const SettingTree& tree, const JoystickPath& path) {
        const auto* whole = tree.as<std::int64_t>();
        const auto* fraction = tree.as<double>();
        const double microseconds = whole != nullptr      ? static_cast<double>(*whole)
                                    : fraction != nullptr ? *fraction
                                                          : 0;
        if (microseconds < 500 || microseconds > 2500) {
            wrong(path, "allowed: a pulse, 500 to 2500 us");
            return std::nullopt;
        }
        return Pulse::from_fractional_microseconds(microseconds);
    }

    std::optional<std::pair<Pulse, Pulse>> range_in(const SettingTree& tree,
                                                    const JoystickPath& path) {
        const auto* ends = tree.as<SettingTree::List>();
        if (ends == nullptr || ends->size() != 2) {
            wrong(path, "allowed: two pulses, such as [1300, 1700]");
            return std::nullopt;
        }
        const auto low = pulse_in(ends->front(), path);
        const auto high = pulse_in(ends->back(), path);
        if (low && high && *low > *high) {
            wrong(path, "allowed: two pulses, the lower one first");
            return std::nullopt;
        }
        return low && high ? std::optional(std::pair(*low, *high)) : std::nullopt;
    }

    const SettingValues& settings_;
    std::vector<SettingMistake>& mistakes_;
};

std::vector<SettingMistake> check_joystick(const SettingValues& settings, SettingScope /*scope*/) {
    std::vector<SettingMistake> mistakes;
    JoystickReader(settings, mistakes).read();
    return mistakes;
}

AnyEncoder make_joystick_encoder(const SettingValues& settings) {
    std::vector<SettingMistake> ignored;
    return std::make_unique<JoystickEncoder>(JoystickReader(settings, ignored).read());
}

}  // namespace

const Protocol kJoystickProtocol{
    .name = "joystick",
    .title = "Joystick",
    .description = "A virtual joystick for simulators on the same machine: 8 axes, 24 buttons",
    .only_on = "a virtual joystick",
    .settings = kJoystickKeys,
    .longest_frame = kJoystickReportBytes,
    .default_period = std::chrono::milliseconds(8),
    .least_period = std::chrono::milliseconds(1),
    .signals_failsafe = never_signals_failsafe,
    .check = check_joystick,
    .dependent_defaults = joystick_defaults,
    .make_encoder = make_joystick_encoder,
};

}  // namespace tribus
