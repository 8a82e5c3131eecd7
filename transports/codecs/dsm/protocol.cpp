#include <array>
#include <chrono>
#include <memory>
#include <string>
#include <string_view>

#include "transports/codecs/dsm/dsm.h"

namespace tribus {
namespace {

constexpr std::array<std::string_view, 2> kDsmScaleChoices{"spektrum", "betaflight"};
constexpr std::array<std::string_view, 3> kDsmResolutionChoices{"auto", "1024", "2048"};
constexpr std::array kDsmSettings{
    Setting{.key = "scale",
            .type = SettingType::choice,
            .fallback = "\"spektrum\"",
            .choices = kDsmScaleChoices,
            .scope = SettingScope::input,
            .help = "How values become microseconds. `spektrum`: 100 % is 1099 and 1901 us, as "
                    "ArduPilot has it; `betaflight`: 1159 and 1841 us",
            .example = "\"betaflight\""},
    Setting{.key = "resolution",
            .type = SettingType::choice,
            .fallback = "\"auto\"",
            .choices = kDsmResolutionChoices,
            .scope = SettingScope::input,
            .help = "Steps of a value. `auto`: the numbers of the channels tell",
            .example = "\"2048\""},
};

AnyDecoder make_dsm_decoder(const SettingValues& settings) {
    const auto scale = settings.get_or<std::string>("scale", "spektrum");
    const auto resolution = settings.get_or<std::string>("resolution", "auto");
    return std::make_unique<DsmDecoder>(
        scale == "betaflight" ? DsmScale::betaflight : DsmScale::spektrum,
        resolution == "1024"   ? DsmResolution::bits_10
        : resolution == "2048" ? DsmResolution::bits_11
                               : DsmResolution::either);
}

}  // namespace

const Protocol kDsmProtocol{
    .name = "dsm",
    .title = "DSM",
    .description = "Spektrum DSM2 and DSMX of satellite receivers, 12 channels",
    .line = {.baud = 115200, .parity = Parity::none, .stop_bits = 1},
    .settings = kDsmSettings,
    .default_period = std::chrono::milliseconds(11),
    .default_timeout = DsmDecoder::kSilence,
    .signals_failsafe = never_signals_failsafe,
    .possible_channels = has_at_most_first<kDsmChannels>,
    .make_decoder = make_dsm_decoder,
};

}  // namespace tribus
