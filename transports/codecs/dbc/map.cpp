#include "transports/codecs/dbc/map.h"

#include <algorithm>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include "core/quantity.h"
#include "core/quotes.h"
#include "transports/codecs/can_codec.h"
#include "transports/codecs/dbc/message_map.h"
#include "transports/codecs/dbc/roles.h"
#include "transports/codecs/dbc/signal_map.h"

namespace tribus {
namespace {

using Mistakes = std::vector<SettingMistake>;

std::string dbc_keys(const SettingTree::Table& table) {
    std::string text;
    for (const SettingEntry& entry : table) {
        text += (text.empty() ? "" : ", ") + in_quotes(entry.key);
    }
    return text;
}

constexpr Duration kLeastCycle = std::chrono::milliseconds(1);
constexpr Duration kMostCycle = std::chrono::seconds(60);

void read_cycles(const SettingValues& settings, const SettingTree::Table& messages, DbcMap& map,
                 Mistakes& mistakes) {
    const auto* tree = settings.find_as<SettingTree>("cycles");
    if (tree == nullptr) {
        return;
    }
    for (const SettingEntry& entry : *tree->as<SettingTree::Table>()) {
        const auto message = std::ranges::find(map.messages, entry.key, &DbcMappedMessage::name);
        const auto* text = entry.value.as<std::string>();
        const auto cycle = text == nullptr ? std::nullopt : parse_duration(*text);
        if (std::ranges::find(messages, entry.key, &SettingEntry::key) == messages.end()) {
            mistakes.push_back({{"cycles", entry.key},
                                "no signal of message " + in_quotes(entry.key) +
                                    " is mapped; allowed: " + dbc_keys(messages)});
        } else if (!cycle || *cycle < kLeastCycle || *cycle > kMostCycle) {
            mistakes.push_back({{"cycles", entry.key},
                                "a cycle time is a duration, text with a unit; allowed: \"1ms\" to "
                                "\"60s\""});
        } else if (message != map.messages.end()) {
            message->cycle = cycle;
        }
    }
}

/// An output may send one channel in several signals; an input would have to choose between them.
/// An output may also send messages without channels, such as a SYNC or a heartbeat.
void check_channels(const DbcMap& map, const SettingTree::Table& messages, SettingScope scope,
                    Mistakes& mistakes) {
    const auto useful = [scope](const DbcPart& part) {
        return !part.channels.empty() || scope == SettingScope::output;
    };
    if (std::ranges::none_of(map.parts, useful)) {
        const std::string_view also =
            scope == SettingScope::output ? ", or SIGNAL = { from = \"battery.voltage\" }" : "";
        mistakes.push_back({{"signals"},
                            "no signal carries a channel; allowed: at least one, such as "
                            "SIGNAL = 1 below the name of its message" +
                                std::string(also)});
    }
    std::map<std::size_t, std::string> sources;
    for (const SettingEntry& message : messages) {
        for (const SettingEntry& signal : *message.value.as<SettingTree::Table>()) {
            Mistakes ignored;
            const auto role = read_dbc_role(signal.value, {}, ignored);
            const auto* channel = role ? std::get_if<DbcChannelRole>(&*role) : nullptr;
            if (scope != SettingScope::input || channel == nullptr) {
                continue;
            }
            const auto [source, first] =
                sources.try_emplace(channel->channel, message.key + "." + signal.key);
            if (!first) {
                mistakes.push_back({{"signals", message.key, signal.key},
                                    "channel " + std::to_string(channel->channel + 1) +
                                        " already comes from " + in_quotes(source->second) +
                                        "; allowed: one signal for each channel"});
            }
        }
    }
}

/// Ids of J1939 match any priority, and some match any source, so they may overlap.
void check_ids(const DbcMap& map, Mistakes& mistakes) {
    for (std::size_t i = 0; i < map.messages.size(); ++i) {
        for (std::size_t j = 0; j < i; ++j) {
            if (map.messages[i].id.overlaps(map.messages[j].id)) {
                mistakes.push_back({{"signals", map.messages[i].name},
                                    "a frame of this message may also be one of " +
                                        in_quotes(map.messages[j].name) +
                                        ", as their ids differ in the priority only, or one of "
                                        "them comes from any source (0xFE); allowed: only one "
                                        "of the two"});
            }
        }
    }
}

void check_part_count(const DbcMap& map, SettingScope scope, Mistakes& mistakes) {
    if (scope == SettingScope::output && map.parts.size() > kMostSnapshotFrames) {
        mistakes.push_back({{"signals"},
                            "they need " + std::to_string(map.parts.size()) +
                                " frames; allowed: at most " +
                                std::to_string(kMostSnapshotFrames)});
    }
}

void check_own_address(const DbcFile& file, const SettingTree::Table& messages, const DbcEnd& end,
                       Mistakes& mistakes) {
    const bool used = std::ranges::any_of(messages, [&](const SettingEntry& entry) {
        const DbcMessage* message = file.find(entry.key);
        return message != nullptr && leaves_source_open(*message);
    });
    if (end.own_address && !used) {
        mistakes.push_back({{"own_address"},
                            "it is for ids of J1939 that the file leaves at 0xFE, but no mapped "
                            "message has one; leave it out"});
    }
}

void read_messages(const DbcFile& file, const SettingTree::Table& messages, const DbcEnd& end,
                   DbcMap& map, Mistakes& mistakes) {
    for (const SettingEntry& entry : messages) {
        const DbcMessage* message = file.find(entry.key);
        const auto* roles = entry.value.as<SettingTree::Table>();
        if (message == nullptr) {
            mistakes.push_back({{"signals", entry.key}, no_dbc_message(file, entry.key)});
        } else if (message->multi_packet) {
            mistakes.push_back({{"signals", entry.key},
                                "the message is longer than a frame; allowed: messages of one "
                                "frame"});
        } else if (roles == nullptr) {
            mistakes.push_back(
                {{"signals", entry.key}, "a message has signals; allowed: MESSAGE.SIGNAL = 1"});
        } else {
            map_dbc_message(*message, *roles, {"signals", entry.key}, end, map, mistakes);
        }
    }
}

/// Whether the frames of this part can tell their receiver not to use the channels in them.
bool says_failsafe(const DbcPart& part) {
    const bool flagged = std::ranges::any_of(part.flags, [](const DbcFlag& flag) {
        return flag.meaning == DbcFlagMeaning::failsafe || flag.meaning == DbcFlagMeaning::good;
    });
    return flagged || std::ranges::all_of(part.channels, [](const DbcChannel& channel) {
               return channel.error || channel.not_available;
           });
}

}  // namespace

std::optional<Duration> DbcMap::shortest_cycle() const {
    std::optional<Duration> shortest;
    for (const DbcPart& part : parts) {
        const auto cycle = messages[part.message].cycle;
        if (!part.channels.empty() && cycle && (!shortest || *cycle < *shortest)) {
            shortest = cycle;
        }
    }
    return shortest;
}

bool DbcMap::signals_failsafe() const {
    bool flagged = false;
    bool coded = true;
    for (const DbcPart& part : parts) {
        for (const DbcFlag& flag : part.flags) {
            flagged = flagged || flag.meaning == DbcFlagMeaning::failsafe ||
                      flag.meaning == DbcFlagMeaning::good;
        }
        for (const DbcChannel& channel : part.channels) {
            coded = coded && (channel.error || channel.not_available);
        }
    }
    return flagged || coded;
}

bool DbcMap::message_signals_failsafe(std::size_t message) const {
    return std::ranges::all_of(parts, [message](const DbcPart& part) {
        return part.message != message || says_failsafe(part);
    });
}

std::optional<Duration> DbcMap::shortest_cycle_of_all() const {
    std::optional<Duration> shortest;
    for (const DbcMappedMessage& message : messages) {
        if (message.cycle && (!shortest || *message.cycle < *shortest)) {
            shortest = message.cycle;
        }
    }
    return shortest;
}

std::vector<SettingMistake> warnings_about_dbc(const DbcFile& file, const std::string& path) {
    constexpr std::size_t kMost = 10;
    Mistakes warnings;
    for (std::size_t i = 0; i < std::min(file.warnings.size(), kMost); ++i) {
        const DbcMistake& wrong = file.warnings[i];
        warnings.push_back({{"dbc"},
                            path + ":" + std::to_string(wrong.line) + ":" +
                                std::to_string(wrong.column) + ": " + wrong.text});
    }
    if (file.warnings.size() > kMost) {
        warnings.push_back({{"dbc"},
                            path + ": and " + std::to_string(file.warnings.size() - kMost) +
                                " more mistakes in what is not used"});
    }
    return warnings;
}

bool DbcMap::needs_channels() const {
    return std::ranges::any_of(
        parts, [](const DbcPart& part) { return !part.channels.empty() || !part.flags.empty(); });
}

tl::expected<DbcMap, std::vector<SettingMistake>> build_dbc_map(const SettingValues& settings,
                                                                SettingScope scope) {
    const auto* text = settings.find_as<SettingFile>("dbc");
    const auto* signals = settings.find_as<SettingTree>("signals");
    if (text == nullptr || signals == nullptr) {
        return tl::unexpected(Mistakes{{{text == nullptr ? "dbc" : "signals"}, "is missing"}});
    }
    const auto file = parse_dbc(text->content);
    if (!file) {
        const DbcMistake& wrong = file.error();
        return tl::unexpected(Mistakes{{{"dbc"},
                                        text->path + ":" + std::to_string(wrong.line) + ":" +
                                            std::to_string(wrong.column) + ": " + wrong.text}});
    }
    DbcMap map;
    Mistakes mistakes;
    const auto& messages = *signals->as<SettingTree::Table>();
    DbcEnd end{.scope = scope};
    if (const auto* address = settings.find_as<std::int64_t>("own_address")) {
        end.own_address = static_cast<std::uint8_t>(*address);
    }
    read_messages(*file, messages, end, map, mistakes);
    check_own_address(*file, messages, end, mistakes);
    read_cycles(settings, messages, map, mistakes);
    if (mistakes.empty()) {
        check_channels(map, messages, scope, mistakes);
        check_ids(map, mistakes);
        check_part_count(map, scope, mistakes);
    }
    if (!mistakes.empty()) {
        return tl::unexpected(std::move(mistakes));
    }
    return map;
}

}  // namespace tribus
