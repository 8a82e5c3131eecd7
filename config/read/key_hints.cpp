#include "config/read/key_hints.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "config/language/protocol_words.h"
#include "core/quotes.h"
#include "transports/links/can/can_medium.h"
#include "transports/links/serial/serial_medium.h"
#include "transports/registry/registry.h"

namespace tribus {
namespace {

// Keys that people expect, in small letters without punctuation.
constexpr std::array<std::string_view, 6> kRates{"bitrate", "baud",  "baudrate",
                                                 "bauds",   "speed", "bps"};
constexpr std::array<std::string_view, 7> kLineSettings{
    "parity", "stopbits", "stopbit", "databits", "bytesize", "bits", "flowcontrol"};
constexpr std::array<std::string_view, 4> kChannelCounts{"channels", "channelcount", "numchannels",
                                                         "nchannels"};

struct CanOption {
    std::string_view key;
    /// The words of `ip link` behind the bit rate. `{}`: the value in the file.
    std::string_view words;
    std::string_view usual;  ///< instead of a value that is no number
};

constexpr std::array kCanOptions{
    CanOption{"dbitrate", "dbitrate {} fd on", "2000000"},
    CanOption{"databitrate", "dbitrate {} fd on", "2000000"},
    CanOption{"fdbitrate", "dbitrate {} fd on", "2000000"},
    CanOption{"bitratefd", "dbitrate {} fd on", "2000000"},
    CanOption{"samplepoint", "sample-point {}", "0.875"},
    CanOption{"restartms", "restart-ms {}", "100"},
    CanOption{"listenonly", "listen-only on", ""},
    CanOption{"loopback", "loopback on", ""},
};
constexpr std::string_view kUsualBitRate = "500000";

template <class Words>
bool is_one_of(std::string_view word, const Words& words) {
    return std::ranges::find(words, word) != words.end();
}

bool has_row(std::span<const Key> keys, std::string_view name) {
    return std::ranges::find(keys, name, &Key::name) != keys.end();
}

std::string interface_of(const Table& table) {
    const Entry* entry = table.find("interface");
    const auto* name = entry == nullptr ? nullptr : entry->value.as<std::string>();
    return name == nullptr || name->empty() ? "can0" : *name;
}

std::string number_or(std::string_view usual, const Value& value) {
    if (const auto* whole = value.as<std::int64_t>()) {
        return fmt::format("{}", *whole);
    }
    const auto* number = value.as<double>();
    return number == nullptr ? std::string(usual) : fmt::format("{}", *number);
}

/// `ip link` refuses these settings while the interface is up.
std::string can_commands(const Table& table, std::string_view options) {
    const std::string link = "sudo ip link set " + interface_of(table);
    return fmt::format("a CAN interface gets it from Linux: {} down; {} up type can bitrate {}",
                       link, link, options);
}

std::optional<std::string> can_hint(const Entry& entry, const Table& table) {
    const std::string key = small_letters_and_digits(entry.key);
    if (is_one_of(key, kRates)) {
        return can_commands(table, number_or(kUsualBitRate, entry.value));
    }
    const auto option = std::ranges::find(kCanOptions, key, &CanOption::key);
    if (option == kCanOptions.end()) {
        return std::nullopt;
    }
    const auto* wanted = entry.value.as<bool>();
    if (wanted != nullptr && !*wanted) {
        return "it is off unless Linux was told otherwise (ip -details link shows it); leave it "
               "out";
    }
    return can_commands(table, fmt::format("{} {}", kUsualBitRate,
                                           fmt::format(fmt::runtime(option->words),
                                                       number_or(option->usual, entry.value))));
}

std::string mean_baud(std::span<const Key> keys) {
    return fmt::format("did you mean \"baud\"? Allowed: {}", in_quotes_all(names_of(keys)));
}

std::optional<std::string> line_hint(std::string_view key, const Protocol& protocol,
                                     std::span<const Key> keys) {
    if (is_one_of(key, kLineSettings)) {
        return fmt::format("protocol {} sets it; leave it out", in_quotes(protocol.name));
    }
    if (!is_one_of(key, kRates)) {
        return std::nullopt;
    }
    return has_row(keys, "baud") ? mean_baud(keys)
                                 : fmt::format("protocol {} always has {} baud; leave it out",
                                               in_quotes(protocol.name), protocol.line.baud);
}

std::optional<std::string> channels_hint(const Entry& entry, const TableRef& ref,
                                         const Protocol& protocol) {
    if (entry.value.as<Table>() != nullptr) {
        return "what is in the channels of an output stands in [pipeline.NAME.channels]";
    }
    const bool other_way = std::ranges::count(protocol.settings, "channels", &Setting::key) != 0;
    const bool has_map =
        std::ranges::count(protocol.settings, SettingType::tree, &Setting::type) != 0;
    if (entry.value.as<std::int64_t>() == nullptr || !protocol.has_channels() || other_way ||
        has_map) {
        return std::nullopt;
    }
    const std::string name = in_quotes(protocol.name);
    if (ref.side == "output") {
        return fmt::format(
            "frames of {} always have the same number of channels; leave it out, or say in "
            "[pipeline.NAME.channels] what is in them",
            name);
    }
    return protocol.sure_channels == nullptr
               ? fmt::format(
                     "the sender of {} decides how many channels come; leave it out, or say with "
                     "\"map\" which ones are used",
                     name)
               : fmt::format(
                     "{} says which channels come; leave it out, or say with \"map\" which ones "
                     "are used",
                     name);
}

}  // namespace

std::optional<std::string> hint_for_key(const Entry& entry, const TableRef& ref,
                                        std::span<const Key> keys) {
    const std::string key = small_letters_and_digits(entry.key);
    const Protocol* const protocol = find_protocol(ref.protocol);
    // A table of values can have an interface or a device.
    const bool on_can = protocol == nullptr ? ref.table.find(kInterfaceSetting.key) != nullptr
                                            : carries(kCanMedium, *protocol);
    if (on_can && has_row(keys, kInterfaceSetting.key)) {
        if (auto hint = can_hint(entry, ref.table)) {
            return hint;
        }
    }
    if (protocol == nullptr) {
        const bool on_line = ref.table.find(kDeviceSetting.key) != nullptr;
        return on_line && has_row(keys, "baud") && is_one_of(key, kRates)
                   ? std::optional(mean_baud(keys))
                   : std::nullopt;
    }
    if (is_one_of(key, kChannelCounts)) {
        return channels_hint(entry, ref, *protocol);
    }
    const bool on_line = has_row(keys, kDeviceSetting.key) && carries(kSerialMedium, *protocol);
    return on_line ? line_hint(key, *protocol, keys) : std::nullopt;
}

}  // namespace tribus
