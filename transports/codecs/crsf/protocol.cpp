#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "transports/codecs/crsf/crsf.h"
#include "transports/codecs/crsf/handset.h"
#include "transports/codecs/crsf/wire.h"

namespace tribus {
namespace {

constexpr std::string_view kHandsetRole = "handset";
constexpr std::array<std::string_view, 2> kRoles{"receiver", kHandsetRole};
constexpr std::string_view kDefaultBaud = "420000";

/// The rates at which a module of ExpressLRS looks for its handset.
constexpr std::array<std::int64_t, 7> kModuleRates{115200,  400000,  921600, 1870000,
                                                   2250000, 3750000, 5250000};

constexpr std::array kCrsfSettings{
    baud_setting(kDefaultBaud, "115200", 5.25e6),
    Setting{.key = "role",
            .type = SettingType::choice,
            .fallback = kRoles[0],
            .choices = kRoles,
            .scope = SettingScope::output,
            .help =
                "`receiver`: sends as a receiver does, to a flight controller; `handset`: sends "
                "to a transmitter module, when the module asks for it",
            .example = "\"handset\""},
    Setting{.key = "model_id",
            .type = SettingType::integer,
            .absent = "none is sent",
            .least = 0,
            .most = 63,
            .scope = SettingScope::output,
            .help =
                "With `role = \"handset\"`: number of the model that the module is told, for its "
                "model match",
            .example = "3"},
};

/// Channels, and statistics, with the usual address.
constexpr std::array kCrsfBeginnings{FrameBeginning{0xC8, 24}, FrameBeginning{0xC8, 12}};

bool is_handset(const SettingValues& settings) {
    return settings.get_or<std::string>("role", {}) == kHandsetRole;
}

std::vector<SettingMistake> check_crsf(const SettingValues& settings, SettingScope scope) {
    std::vector<SettingMistake> mistakes;
    if (scope != SettingScope::output) {
        return mistakes;
    }
    if (!is_handset(settings)) {
        if (settings.find("model_id") != nullptr) {
            mistakes.push_back({{"model_id"},
                                "\"model_id\" has no effect without role = \"handset\"; leave it "
                                "out"});
        }
        return mistakes;
    }
    const auto* baud = settings.find_as<std::int64_t>("baud");
    if (baud != nullptr && std::ranges::count(kModuleRates, *baud) == 0) {
        mistakes.push_back({{"baud"},
                            "\"baud\" is " + std::to_string(*baud) +
                                (std::to_string(*baud) == kDefaultBaud ? ", the default" : "") +
                                ", but a transmitter module does not look for its handset at this "
                                "rate; allowed: 115200, 400000, 921600, 1870000, 2250000, 3750000, "
                                "5250000"});
    }
    return mistakes;
}

/// The period of EdgeTX until the module asks for another one.
std::optional<Duration> crsf_period(const SettingValues& settings) {
    using std::chrono::milliseconds;
    if (!is_handset(settings)) {
        return std::nullopt;
    }
    const auto baud = settings.get_or<std::int64_t>("baud", 400000);
    return baud <= 115200 ? milliseconds(16) : baud <= 400000 ? milliseconds(4) : milliseconds(2);
}

AnyDecoder make_crsf_decoder(const SettingValues& /*settings*/) {
    return std::make_unique<CrsfDecoder>();
}

AnyEncoder make_crsf_encoder(const SettingValues& settings) {
    if (!is_handset(settings)) {
        return std::make_unique<CrsfEncoder>();
    }
    const auto* model = settings.find_as<std::int64_t>("model_id");
    return std::make_unique<CrsfHandsetEncoder>(
        model == nullptr ? std::nullopt : std::optional(static_cast<std::uint8_t>(*model)));
}

}  // namespace

// 150 Hz is a rate of ExpressLRS that every flight controller takes. Receivers of ExpressLRS send
// up to 1000 Hz; a slow line limits the rate further.
const Protocol kCrsfProtocol{
    .name = "crsf",
    .title = "CRSF",
    .description = "TBS CRSF of ExpressLRS, Crossfire, Tracer and mLRS receivers, 16 channels",
    .line = {.baud = 420000, .parity = Parity::none, .stop_bits = 1},
    .beginnings = kCrsfBeginnings,
    .settings = kCrsfSettings,
    .longest_frame = crsf_wire::kChannelsFrameBytes + crsf_wire::kStatisticsFrameBytes,
    .default_period = std::chrono::microseconds(6667),
    .own_period = crsf_period,
    .least_period = std::chrono::milliseconds(2),
    .least_spacing = std::chrono::milliseconds(4),
    .default_timeout = CrsfDecoder::kNoChannelsAfter,
    .signals_failsafe = never_signals_failsafe,
    // Frames of type 17 could carry more, but no sender is known that does.
    .possible_channels = has_at_most_first<16>,
    .check = check_crsf,
    .is_timed_by_receiver = is_handset,
    .make_decoder = make_crsf_decoder,
    .make_encoder = make_crsf_encoder,
};

}  // namespace tribus
