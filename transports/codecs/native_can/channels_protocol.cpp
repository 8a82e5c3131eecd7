#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "transports/codecs/authenticated/broadcast_ends.h"
#include "transports/codecs/authenticated/classic_ends.h"
#include "transports/codecs/authenticated/link_settings.h"
#include "transports/codecs/native_can/channels.h"

namespace tribus {
namespace {

using can_channels::kFdIndex;

constexpr std::array<std::string_view, 2> kCrcChoices{"p22", "p01"};
constexpr std::array<std::string_view, 2> kChannelsChoices{"16", "18"};
constexpr std::array kSettings{
    Setting{.key = "id",
            .type = SettingType::integer,
            .fallback = "768",
            .least = 0,
            .most = kMostExtendedId - kFdIndex,
            .help =
                "First of six CAN ids in a row: five for classic frames, one for FD; with `key` "
                "classic frames have fifteen; 768 is 0x300",
            .example = "0x200"},
    Setting{.key = "extended",
            .type = SettingType::boolean,
            .fallback = "false",
            .help = "`true`: ids of 29 bits",
            .example = "true"},
    Setting{.key = "fd",
            .type = SettingType::boolean,
            .fallback = "false",
            .help = "`true`: one CAN FD frame of 48 bytes a snapshot, in steps of 0.125 us, "
                    "instead of five classic frames",
            .example = "true"},
    Setting{.key = "crc",
            .type = SettingType::choice,
            .fallback = "\"p22\"",
            .choices = kCrcChoices,
            .help = "AUTOSAR E2E profile of classic frames, 22 or 1; FD frames always have "
                    "profile 5",
            .example = "\"p01\""},
    Setting{.key = "channels",
            .type = SettingType::integer,
            .fallback = "18",
            .choices = kChannelsChoices,
            .help = "18, or 16 and two switches, which saves one of five classic frames",
            .example = "16"},
    authenticated::kKeySetting,
    authenticated::kOldKeySetting,
    authenticated::kLinkSetting,
    authenticated::kEpochSetting,
};
static_assert(can_channels::kDefaultBaseId == 768);

void check_ids(const CanChannelsFormat& format, std::size_t ids,
               std::vector<SettingMistake>& mistakes) {
    const auto most =
        (format.extended ? kMostExtendedId : kMostStandardId) - static_cast<std::uint32_t>(ids - 1);
    if (format.base_id > most) {
        mistakes.push_back({{"id"},
                            fmt::format("{0} is too high for ids of {1} bits; allowed is 0 to {2} "
                                        "(0x{2:X}){3}",
                                        format.base_id, format.extended ? 29 : 11, most,
                                        format.extended ? "" : ", or more with extended = true")});
    }
}

std::vector<SettingMistake> check(const SettingValues& settings, SettingScope /*scope*/) {
    std::vector<SettingMistake> mistakes;
    const CanChannelsFormat format = CanChannelsFormat::from_settings(settings);
    const bool classic_link = !format.fd && settings.find("key") != nullptr;
    check_ids(format, classic_link ? authenticated::kClassicIds : can_channels::kIds, mistakes);
    authenticated::check_link(settings, mistakes);
    if (classic_link && format.crc == CanChannelsCrc::p01) {
        mistakes.push_back({{"crc"},
                            "\"p01\" is for frames without a key, which proves more than a CRC: "
                            "leave out crc, or key"});
    }
    if (classic_link && format.channels != kChannelCount) {
        mistakes.push_back({{"channels"},
                            std::to_string(format.channels) +
                                " is for frames without a key; a link with a key always has 18 "
                                "channels: leave out channels, or key"});
    }
    if (format.fd && format.crc == CanChannelsCrc::p01) {
        mistakes.push_back({{"crc"},
                            "\"p01\" is for classic frames; FD frames always have profile 5: "
                            "leave out crc, or fd"});
    }
    if (format.fd && format.channels != kChannelCount) {
        mistakes.push_back({{"channels"},
                            std::to_string(format.channels) +
                                " is for classic frames; an FD frame always has 18 channels: "
                                "leave out channels, or fd"});
    }
    return mistakes;
}

std::optional<std::uint32_t> sure_channels(const SettingValues& settings) {
    return first_channels(CanChannelsFormat::from_settings(settings).channels);
}

std::optional<LinkWithKey> link_with_key(const SettingValues& settings) {
    const CanChannelsFormat format = CanChannelsFormat::from_settings(settings);
    return authenticated::link_of(settings, (format.fd ? "can fd " : "can ") +
                                                std::to_string(format.base_id) +
                                                (format.extended ? "x" : ""));
}

/// Snapshots have the id of plain FD frames, and challenges the first of the ids, which FD does not
/// need.
authenticated::FdLink fd_link(const LinkWithKey& link, const CanChannelsFormat& format) {
    return {.keys = link,
            .sender_id = format.base_id + static_cast<std::uint32_t>(kFdIndex),
            .receiver_id = format.base_id,
            .extended = format.extended};
}

authenticated::ClassicLink classic_link(const LinkWithKey& link, const CanChannelsFormat& format) {
    return {.keys = link, .first_id = format.base_id, .extended = format.extended};
}

AnyDecoder make_decoder(const SettingValues& settings) {
    const CanChannelsFormat format = CanChannelsFormat::from_settings(settings);
    const auto link = link_with_key(settings);
    if (!link) {
        return std::make_unique<CanChannelsDecoder>(format);
    }
    if (format.fd) {
        return authenticated::make_fd_decoder(fd_link(*link, format));
    }
    return std::make_unique<authenticated::ClassicDecoder>(classic_link(*link, format));
}

AnyEncoder make_encoder(const SettingValues& settings) {
    const CanChannelsFormat format = CanChannelsFormat::from_settings(settings);
    const auto link = link_with_key(settings);
    if (!link) {
        return std::make_unique<CanChannelsEncoder>(format);
    }
    if (format.fd) {
        return authenticated::make_fd_encoder(fd_link(*link, format));
    }
    return std::make_unique<authenticated::ClassicEncoder>(classic_link(*link, format));
}

// Least period at 1 Mbit/s, where five frames take 0.7 ms. At 125 kbit/s they take 5.4 ms.
constexpr Duration kLeastPeriod = std::chrono::milliseconds(2);
static_assert(CanChannelsDecoder::kWindow < 15 * kLeastPeriod,
              "no part may meet those of the snapshot that has the same counter next");
static_assert(kChannelCount == 18);

}  // namespace

CanChannelsFormat CanChannelsFormat::from_settings(const SettingValues& settings) {
    return {.base_id = static_cast<std::uint32_t>(
                settings.get_or<std::int64_t>("id", can_channels::kDefaultBaseId)),
            .extended = settings.get_or<bool>("extended", false),
            .fd = settings.get_or<bool>("fd", false),
            .crc = settings.get_or<std::string>("crc", "p22") == "p01" ? CanChannelsCrc::p01
                                                                       : CanChannelsCrc::p22,
            .channels = static_cast<std::size_t>(settings.get_or<std::int64_t>(
                "channels", static_cast<std::int64_t>(kChannelCount)))};
}

const Protocol kCanProtocol{
    .name = "can",
    .title = "CAN",
    .description = "The native format: 16 or 18 channels in protected CAN or CAN FD frames",
    .shape = WireShape::can_frames,
    .line = {},
    .settings = kSettings,
    .default_period = std::chrono::milliseconds(can_channels::kDefaultPeriodMilliseconds),
    .least_period = kLeastPeriod,
    .signals_failsafe = always_signals_failsafe,
    .sure_channels = sure_channels,
    .check = check,
    .link_with_key = link_with_key,
    .make_decoder = make_decoder,
    .make_encoder = make_encoder,
};

}  // namespace tribus
