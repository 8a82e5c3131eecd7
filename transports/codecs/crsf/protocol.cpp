#include <array>
#include <chrono>
#include <memory>

#include "transports/codecs/crsf/crsf.h"
#include "transports/codecs/crsf/wire.h"

namespace tribus {
namespace {

constexpr std::array kCrsfSettings{baud_setting("420000", "115200", 5.25e6)};

AnyDecoder make_crsf_decoder(const SettingValues& /*settings*/) {
    return std::make_unique<CrsfDecoder>();
}

AnyEncoder make_crsf_encoder(const SettingValues& /*settings*/) {
    return std::make_unique<CrsfEncoder>();
}

}  // namespace

// 150 Hz is a rate of ExpressLRS that every flight controller takes; 250 Hz is the fastest that
// also fits a line of 115200 baud.
const Protocol kCrsfProtocol{
    .name = "crsf",
    .title = "CRSF",
    .description = "TBS CRSF of ExpressLRS, Crossfire, Tracer and mLRS receivers, 16 channels",
    .line = {.baud = 420000, .parity = Parity::none, .stop_bits = 1},
    .settings = kCrsfSettings,
    .longest_frame = crsf_wire::kChannelsFrameBytes + crsf_wire::kStatisticsFrameBytes,
    .default_period = std::chrono::microseconds(6667),
    .least_period = std::chrono::milliseconds(4),
    .default_timeout = CrsfDecoder::kNoChannelsAfter,
    .signals_failsafe = never_signals_failsafe,
    .make_decoder = make_crsf_decoder,
    .make_encoder = make_crsf_encoder,
};

}  // namespace tribus
