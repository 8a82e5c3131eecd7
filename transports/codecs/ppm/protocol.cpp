#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>

#include "transports/codecs/ppm/ppm.h"

namespace tribus {
namespace {

constexpr std::array<std::string_view, 3> kMedians{"1", "3", "5"};
constexpr std::int64_t kUsualSentChannels = 8;

constexpr std::array kPpmSettings{
    Setting{.key = "median",
            .type = SettingType::integer,
            .fallback = "1",
            .choices = kMedians,
            .scope = SettingScope::input,
            .help = "Each channel is the middle one of so many frames: `1`, `3` or `5`. `3` hides "
                    "one wrong pulse, and sticks come a frame later, 22.5 ms or more",
            .example = "3"},
    Setting{.key = "channels",
            .type = SettingType::integer,
            .fallback = "8",
            .least = ppm::kLeastChannels,
            .most = ppm::kMostSentChannels,
            .scope = SettingScope::output,
            .help = "How many channels are sent, the first ones",
            .example = "6"},
};

std::size_t sent_channels(const SettingValues& settings) {
    return static_cast<std::size_t>(settings.get_or("channels", kUsualSentChannels));
}

std::size_t median_of(const SettingValues& settings) {
    return static_cast<std::size_t>(settings.get_or("median", std::int64_t{1}));
}

/// Nothing for an input, whose sender decides.
std::optional<Duration> sent_period(const SettingValues& settings) {
    return settings.find("channels") == nullptr
               ? std::nullopt
               : std::optional(ppm_period(sent_channels(settings)));
}

constexpr std::size_t longest_records() {
    return (ppm::kMostSentChannels + 2) * edge_records::kRecordBytes;
}
static_assert(longest_records() <= kLongestSerialFrame);

}  // namespace

// A frame of 18 channels takes up to 45 ms.
const Protocol kPpmProtocol{
    .name = "ppm",
    .title = "PPM",
    .description = "The sum of pulses (CPPM) of trainer ports and old receivers",
    .only_on = "a pulse line",
    .settings = kPpmSettings,
    .longest_frame = longest_records(),
    .default_period = ppm_period(kUsualSentChannels),
    .own_period = sent_period,
    .least_period = std::chrono::microseconds(22500),
    .default_timeout = std::chrono::milliseconds(150),
    .signals_failsafe = never_signals_failsafe,
    .make_decoder = [](const SettingValues& settings) -> AnyDecoder {
        return std::make_unique<PpmDecoder>(median_of(settings));
    },
    .make_encoder = [](const SettingValues& settings) -> AnyEncoder {
        return std::make_unique<PpmEncoder>(sent_channels(settings));
    },
};

}  // namespace tribus
