#include "config/read/key_hints.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>

#include "core/quotes.h"
#include "transports/links/serial/serial_medium.h"
#include "transports/registry/registry.h"

namespace tribus {
namespace {

/// A key that people expect, in small letters without punctuation.
struct CanOption {
    std::string_view key;
    /// The words of `ip link` for it. `{}`: the value in the file.
    std::string_view words;
    std::string_view usual;  ///< the value if that in the file is no whole number
};

constexpr std::array kCanOptions{
    CanOption{"bitrate", "bitrate {}", "500000"},
    CanOption{"baud", "bitrate {}", "500000"},
    CanOption{"baudrate", "bitrate {}", "500000"},
    CanOption{"speed", "bitrate {}", "500000"},
    CanOption{"dbitrate", "bitrate 500000 dbitrate {} fd on", "2000000"},
    CanOption{"databitrate", "bitrate 500000 dbitrate {} fd on", "2000000"},
    CanOption{"fdbitrate", "bitrate 500000 dbitrate {} fd on", "2000000"},
    CanOption{"bitratefd", "bitrate 500000 dbitrate {} fd on", "2000000"},
    CanOption{"samplepoint", "bitrate 500000 sample-point 0.875", ""},
    CanOption{"restartms", "bitrate 500000 restart-ms {}", "100"},
    CanOption{"listenonly", "bitrate 500000 listen-only on", ""},
    CanOption{"loopback", "bitrate 500000 loopback on", ""},
};

constexpr std::array<std::string_view, 5> kRates{"bitrate", "baudrate", "bauds", "speed", "bps"};
constexpr std::array<std::string_view, 7> kLineSettings{
    "parity", "stopbits", "stopbit", "databits", "bytesize", "bits", "flowcontrol"};
constexpr std::array<std::string_view, 4> kChannelCounts{"channels", "channelcount", "numchannels",
                                                         "nchannels"};

/// "bit_rate" and "bit-rate" are "bitrate".
std::string plain_key(std::string_view key) {
    std::string plain;
    for (const char c : key) {
        if (std::isalnum(static_cast<unsigned char>(c)) != 0) {
            plain += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
        }
    }
    return plain;
}

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

std::optional<std::string> can_hint(const Entry& entry, const Table& table) {
    const auto option = std::ranges::find(kCanOptions, plain_key(entry.key), &CanOption::key);
    if (option == kCanOptions.end()) {
        return std::nullopt;
    }
    const auto* number = entry.value.as<std::int64_t>();
    const std::string value =
        number == nullptr ? std::string(option->usual) : fmt::format("{}", *number);
    return fmt::format("a CAN interface gets it from Linux: sudo ip link set {} up type can {}",
                       interface_of(table), fmt::format(fmt::runtime(option->words), value));
}

std::optional<std::string> line_hint(std::string_view key, const Protocol& protocol,
                                     std::span<const Key> keys) {
    if (is_one_of(key, kLineSettings)) {
        return fmt::format("protocol {} says what it is; leave it out", in_quotes(protocol.name));
    }
    if (!is_one_of(key, kRates) && key != "baud") {
        return std::nullopt;
    }
    return has_row(keys, "baud")
               ? fmt::format("did you mean \"baud\"? Allowed: {}", in_quotes_all(names_of(keys)))
               : fmt::format("protocol {} always has {} baud; leave it out",
                             in_quotes(protocol.name), protocol.line.baud);
}

std::optional<std::string> channels_hint(const TableRef& ref, const Protocol& protocol) {
    const bool other_way = std::ranges::count(protocol.settings, "channels", &Setting::key) != 0;
    const bool has_map =
        std::ranges::count(protocol.settings, SettingType::tree, &Setting::type) != 0;
    if (other_way || has_map) {
        return std::nullopt;
    }
    return ref.side == "input"
               ? fmt::format(
                     "the sender of {} decides how many channels come; leave it out, or "
                     "say with \"map\" which ones are used",
                     in_quotes(protocol.name))
               : fmt::format(
                     "frames of {} always have the same number of channels; leave it out, "
                     "or say in [pipeline.NAME.channels] what is in them",
                     in_quotes(protocol.name));
}

}  // namespace

std::optional<std::string> hint_for_key(const Entry& entry, const TableRef& ref,
                                        std::span<const Key> keys) {
    const std::string key = plain_key(entry.key);
    if (has_row(keys, "interface")) {
        if (auto hint = can_hint(entry, ref.table)) {
            return hint;
        }
    }
    const Protocol* const protocol = find_protocol(ref.protocol);
    if (protocol == nullptr) {
        return std::nullopt;
    }
    if (is_one_of(key, kChannelCounts)) {
        return channels_hint(ref, *protocol);
    }
    const bool on_line = has_row(keys, kDeviceSetting.key) && carries(kSerialMedium, *protocol);
    return on_line ? line_hint(key, *protocol, keys) : std::nullopt;
}

}  // namespace tribus
