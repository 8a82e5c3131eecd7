#include "transports/codecs/sitl/sitl.h"

#include <array>
#include <chrono>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "transports/codecs/microsecond_words.h"

namespace tribus {

std::uint32_t SitlEncoder::needed_channels(const ChannelFrame& /*frame*/) const {
    return first_channels(channels_);
}

std::size_t SitlEncoder::write(const ChannelFrame& frame,
                               std::span<std::uint8_t, kLongestSerialFrame> wire, Instant /*now*/) {
    for (std::size_t channel = 0; channel < channels_; ++channel) {
        microsecond_words::put_microseconds(wire, 2 * channel,
                                            microsecond_words::microseconds_of(frame, channel));
    }
    return 2 * channels_;
}

namespace {

constexpr std::size_t kMostSitlChannels = 16;
constexpr std::array<std::string_view, 2> kSitlCounts{"8", "16"};

constexpr std::array kSitlSettings{
    Setting{.key = "channels",
            .type = SettingType::integer,
            .fallback = kSitlCounts[1],
            .least = 8,
            .most = kMostSitlChannels,
            .scope = SettingScope::output,
            .help = "How many channels are sent: 8 or 16",
            .example = kSitlCounts[0]},
};

std::vector<SettingMistake> check_sitl(const SettingValues& settings, SettingScope /*scope*/) {
    const auto channels = settings.get_or<std::int64_t>("channels", kMostSitlChannels);
    if (channels == 8 || channels == kMostSitlChannels) {
        return {};
    }
    return {{{"channels"},
             "\"channels\" is " + std::to_string(channels) +
                 ", and SITL reads datagrams of two lengths only; allowed: 8, 16"}};
}

AnyEncoder make_sitl_encoder(const SettingValues& settings) {
    return std::make_unique<SitlEncoder>(
        static_cast<std::size_t>(settings.get_or<std::int64_t>("channels", kMostSitlChannels)));
}

}  // namespace

const Protocol kSitlProtocol{
    .name = "sitl",
    .title = "SITL",
    .description = "RC input of ArduPilot's simulator SITL, its UDP port 5501",
    .only_on = "UDP",
    .settings = kSitlSettings,
    .longest_frame = 2 * kMostSitlChannels,
    .default_period = std::chrono::milliseconds(20),
    .least_period = std::chrono::milliseconds(2),
    .signals_failsafe = never_signals_failsafe,
    .check = check_sitl,
    .make_encoder = make_sitl_encoder,
};

}  // namespace tribus
