#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/gamepad_report.h"
#include "transports/codecs/gamepad/codes.h"
#include "transports/codecs/gamepad/gamepad.h"
#include "transports/codecs/setting_tables.h"

namespace tribus {
namespace {

constexpr std::array kGamepadKeys{
    Setting{.key = "axes",
            .type = SettingType::tree,
            .absent = "`{ ABS_RX = 1, ABS_RY = 2, ABS_Y = { channel = 3, reverse = true }, ABS_X = "
                      "4 }`",
            .scope = SettingScope::input,
            .help = "The channel of each axis, by the kernel's names, as `tribus learn` and "
                    "`evtest` show them; or a table with `channel` and `reverse = true`",
            .example = "{ ABS_X = 1, ABS_Y = { channel = 2, reverse = true } }"},
    Setting{.key = "buttons",
            .type = SettingType::tree,
            .absent = "`{ BTN_SOUTH = 5, BTN_EAST = 6, BTN_WEST = 7, BTN_NORTH = 8 }`",
            .scope = SettingScope::input,
            .help = "The channel of each button: 1000 us, pressed 2000 us; or a table with "
                    "`channel` and `toggle = true`: each press changes it",
            .example = "{ BTN_SOUTH = 5, BTN_START = { channel = 6, toggle = true } }"},
    Setting{.key = "dead_man",
            .type = SettingType::text,
            .absent = "none",
            .scope = SettingScope::input,
            .help = "A button that must be held: the link is lost while it is not pressed",
            .example = "\"BTN_TL\""},
    Setting{.key = "activity_timeout",
            .type = SettingType::duration,
            .absent = "never",
            .least = 0.1,
            .most = 3600,
            .scope = SettingScope::input,
            .help = "The link is lost if nothing moved for so long. Only for pads whose sticks "
                    "never rest quite still; others are silent in a still hand",
            .example = "\"2s\""},
};

SettingTree::Table usual_gamepad_axes() {
    const SettingTree::Table turned{channel_entry("channel", 2), {"reverse", SettingTree{true}}};
    return {channel_entry("ABS_RX", 0),
            channel_entry("ABS_RY", 1),
            {"ABS_Y", SettingTree{turned}},
            channel_entry("ABS_X", 3)};
}

SettingTree::Table usual_gamepad_buttons() {
    return {channel_entry("BTN_SOUTH", 4), channel_entry("BTN_EAST", 5),
            channel_entry("BTN_WEST", 6), channel_entry("BTN_NORTH", 7)};
}

SettingValues gamepad_defaults(const SettingValues& /*settings*/, SettingScope /*way*/) {
    SettingValues defaults;
    defaults.set("axes", SettingTree{usual_gamepad_axes()});
    defaults.set("buttons", SettingTree{usual_gamepad_buttons()});
    return defaults;
}

using GamepadPath = std::vector<std::string>;

/// The channel of an axis or a button, and its one flag.
struct Mapped {
    std::size_t channel = 0;
    bool flag = false;
};

/// Reads the tables of axes and buttons, and collects mistakes.
class GamepadReader {
  public:
    GamepadReader(const SettingValues& settings, std::vector<SettingMistake>& mistakes)
        : settings_(settings), mistakes_(mistakes) {}

    GamepadSettings read() {
        GamepadSettings gamepad;
        read_axes(gamepad);
        read_buttons(gamepad);
        if (const auto* name = settings_.find_as<std::string>("dead_man")) {
            gamepad.dead_man = gamepad_button_code(*name);
            if (!gamepad.dead_man) {
                wrong({"dead_man"}, "\"dead_man\" is \"" + *name +
                                        "\", no button of a gamepad; allowed: a name such as "
                                        "\"BTN_TL\", as `evtest` shows it");
            }
        }
        if (const auto* timeout = settings_.find_as<Duration>("activity_timeout")) {
            gamepad.activity_timeout = *timeout;
        }
        if (gamepad.axes.empty() && gamepad.buttons.empty() && mistakes_.empty()) {
            wrong({}, "it has no channel; allowed: at least one of axes and buttons");
        }
        return gamepad;
    }

  private:
    void wrong(GamepadPath path, std::string text) {
        mistakes_.push_back({std::move(path), std::move(text)});
    }

    void read_axes(GamepadSettings& gamepad) {
        const auto* entries = table_of(settings_, "axes");
        for (const SettingEntry& entry : entries == nullptr ? usual_gamepad_axes() : *entries) {
            const auto code = gamepad_axis_code(entry.key);
            const auto mapped = read_mapped(entry, "axes", "reverse");
            if (!code) {
                wrong({"axes", entry.key},
                      "no axis; allowed: a name such as ABS_X, as `evtest` "
                      "shows it");
            } else if (mapped) {
                gamepad.axes.push_back({*code, mapped->channel, mapped->flag});
            }
        }
    }

    void read_buttons(GamepadSettings& gamepad) {
        const auto* entries = table_of(settings_, "buttons");
        for (const SettingEntry& entry : entries == nullptr ? usual_gamepad_buttons() : *entries) {
            const auto code = gamepad_button_code(entry.key);
            const auto mapped = read_mapped(entry, "buttons", "toggle");
            if (!code) {
                wrong({"buttons", entry.key},
                      "no button of a gamepad; allowed: a name such as "
                      "BTN_SOUTH, as `evtest` shows it");
            } else if (mapped) {
                gamepad.buttons.push_back({*code, mapped->channel, mapped->flag});
            }
        }
    }

    /// A channel, or a table with a channel and a flag.
    std::optional<Mapped> read_mapped(const SettingEntry& entry, const std::string& key,
                                      std::string_view flag) {
        const auto* parts = entry.value.as<SettingTree::Table>();
        std::optional<std::size_t> channel;
        bool on = false;
        if (parts == nullptr) {
            channel = channel_of(entry.value);
        }
        for (const SettingEntry& part : parts == nullptr ? SettingTree::Table{} : *parts) {
            const auto* value = part.value.as<bool>();
            if (part.key == "channel") {
                channel = channel_of(part.value);
            } else if (part.key == flag && value != nullptr) {
                on = *value;
            } else {
                wrong({key, entry.key, part.key},
                      "allowed: channel, and " + std::string(flag) + " = true or false");
                return std::nullopt;
            }
        }
        if (!channel) {
            wrong({key, entry.key},
                  "allowed: a channel, 1 to 18, or a table with channel and " + std::string(flag));
            return std::nullopt;
        }
        return Mapped{*channel, on};
    }

    const SettingValues& settings_;
    std::vector<SettingMistake>& mistakes_;
};

std::vector<SettingMistake> check_gamepad(const SettingValues& settings, SettingScope /*scope*/) {
    std::vector<SettingMistake> mistakes;
    GamepadReader(settings, mistakes).read();
    return mistakes;
}

AnyDecoder make_gamepad_decoder(const SettingValues& settings) {
    std::vector<SettingMistake> ignored;
    return std::make_unique<GamepadDecoder>(GamepadReader(settings, ignored).read());
}

}  // namespace

// The link makes a report every 20 ms.
const Protocol kGamepadProtocol{
    .name = "gamepad",
    .title = "Gamepad",
    .description = "A gamepad or joystick at this machine",
    .only_on = "an input device",
    .settings = kGamepadKeys,
    .longest_frame = gamepad_report::kMostBytes,
    .default_period = std::chrono::milliseconds(20),
    .least_period = std::chrono::milliseconds(20),
    .signals_failsafe = always_signals_failsafe,
    .check = check_gamepad,
    .dependent_defaults = gamepad_defaults,
    .make_decoder = make_gamepad_decoder,
};

}  // namespace tribus
