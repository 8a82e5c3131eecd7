#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/can_frame.h"
#include "core/channel_frame.h"
#include "core/setting.h"
#include "core/time.h"
#include "transports/codecs/can_codec.h"
#include "transports/codecs/dbc/map.h"

/// Maps of DBC signals, written as JSON instead of TOML.
namespace tribus::test {

using std::chrono::milliseconds;

inline SettingTree setting_tree(const nlohmann::ordered_json& json) {
    if (json.is_object()) {
        SettingTree::Table table;
        for (const auto& [key, value] : json.items()) {
            table.push_back({key, setting_tree(value)});
        }
        return {std::move(table)};
    }
    if (json.is_array()) {
        SettingTree::List list;
        for (const auto& item : json) {
            list.push_back(setting_tree(item));
        }
        return {std::move(list)};
    }
    if (json.is_string()) {
        return {json.get<std::string>()};
    }
    if (json.is_boolean()) {
        return {json.get<bool>()};
    }
    return json.is_number_integer() ? SettingTree{json.get<std::int64_t>()}
                                    : SettingTree{json.get<double>()};
}

inline SettingTree setting_tree(std::string_view json) {
    return setting_tree(nlohmann::ordered_json::parse(json));
}

inline SettingValues dbc_settings(std::string_view dbc, std::string_view signals,
                                  std::string_view cycles = {}) {
    SettingValues settings;
    settings.set("dbc", SettingFile{"bus.dbc", std::string(dbc)});
    settings.set("signals", setting_tree(signals));
    if (!cycles.empty()) {
        settings.set("cycles", setting_tree(cycles));
    }
    return settings;
}

/// The end of a DBC file in which the messages with these ids, as it writes them, are J1939 ones.
inline std::string j1939_frames(std::initializer_list<std::uint32_t> ids) {
    std::string text =
        "BA_DEF_ BO_ \"VFrameFormat\" ENUM \"StandardCAN\",\"ExtendedCAN\",\"reserved\","
        "\"J1939PG\";\n";
    for (const std::uint32_t id : ids) {
        text += "BA_ \"VFrameFormat\" BO_ " + std::to_string(id) + " 3;\n";
    }
    return text;
}

/// Returns each mistake as "signals.Command.Speed: what is wrong".
inline std::vector<std::string> told(const std::vector<SettingMistake>& mistakes) {
    std::vector<std::string> lines;
    for (const SettingMistake& mistake : mistakes) {
        std::string path;
        for (const std::string& key : mistake.path) {
            path += (path.empty() ? "" : ".") + key;
        }
        lines.push_back(path + ": " + mistake.text);
    }
    return lines;
}

inline DbcMap dbc_map(const SettingValues& settings, SettingScope scope) {
    auto map = build_dbc_map(settings, scope);
    if (!map) {
        ADD_FAILURE() << told(map.error()).front();
        return {};
    }
    return std::move(*map);
}

/// The map of an input.
inline DbcMap received_map(std::string_view dbc, std::string_view signals,
                           std::string_view cycles = {}) {
    return dbc_map(dbc_settings(dbc, signals, cycles), SettingScope::input);
}

using CanFrames = std::vector<CanFrame>;

inline Instant at(int milliseconds_since_start) {
    return Instant{} + std::chrono::seconds(1000) + milliseconds(milliseconds_since_start);
}

inline CanFrame standard_frame(std::uint32_t id, const std::vector<std::uint8_t>& data) {
    CanFrame frame{.id = id, .length = static_cast<std::uint8_t>(data.size())};
    std::ranges::copy(data, frame.data.begin());
    return frame;
}

inline CanFrame extended_frame(std::uint32_t id, const std::vector<std::uint8_t>& data) {
    CanFrame frame = standard_frame(id, data);
    frame.extended = true;
    return frame;
}

inline std::vector<std::uint8_t> bytes_of(const CanFrame& frame) {
    return {frame.bytes().begin(), frame.bytes().end()};
}

inline CanFrames frames_of(CanEncoder& encoder, const ChannelFrame& snapshot, Instant now) {
    std::array<CanFrame, kMostSnapshotFrames> frames{};
    const std::size_t count = encoder.write(snapshot, frames, now);
    return {frames.begin(), frames.begin() + static_cast<std::ptrdiff_t>(count)};
}

inline std::uint64_t rejected(const DecoderReport& decoder, std::string_view cause) {
    for (const NamedCount& entry : decoder.rejected()) {
        if (entry.name == cause) {
            return entry.count;
        }
    }
    ADD_FAILURE() << "no such cause: " << cause;
    return 0;
}

/// Returns a good frame whose first channels have these values in microseconds.
inline ChannelFrame channels(const std::vector<double>& pulses_us) {
    ChannelFrame frame;
    for (std::size_t channel = 0; channel < pulses_us.size(); ++channel) {
        frame.set(channel, Pulse::from_fractional_microseconds(pulses_us[channel]));
    }
    frame.frame_lost = frame.failsafe = false;
    return frame;
}

}  // namespace tribus::test
