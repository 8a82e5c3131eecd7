#include <array>
#include <chrono>
#include <memory>

#include "transports/codecs/ghst/ghst.h"
#include "transports/codecs/ghst/wire.h"

namespace tribus {
namespace {

constexpr std::array kGhstSettings{baud_setting("420000", "400000")};

constexpr std::array kGhstBeginnings{
    FrameBeginning{ghst_wire::kGhstAddress, ghst_wire::kGhstLength}};

AnyDecoder make_ghst_decoder(const SettingValues& /*settings*/) {
    return std::make_unique<GhstDecoder>();
}

AnyEncoder make_ghst_encoder(const SettingValues& /*settings*/) {
    return std::make_unique<GhstEncoder>();
}

}  // namespace

// 250 Hz and 500 Hz are rates of Ghost receivers. At 250 Hz channels 5 to 16 come each 12 ms.
const Protocol kGhstProtocol{
    .name = "ghst",
    .title = "GHST",
    .description = "GHST of ImmersionRC Ghost receivers, 16 channels, 5 to 16 by turns",
    .line = {.baud = 420000, .parity = Parity::none, .stop_bits = 1},
    .beginnings = kGhstBeginnings,
    .settings = kGhstSettings,
    .longest_frame = ghst_wire::kGhstFrameBytes,
    .default_period = std::chrono::milliseconds(4),
    .least_period = std::chrono::milliseconds(2),
    .default_timeout = GhstDecoder::kNoChannelsAfter,
    .signals_failsafe = never_signals_failsafe,
    .sure_channels = always_has_first<ghst_wire::kGhstFineChannels>,
    .possible_channels = has_at_most_first<ghst_wire::kGhstChannels>,
    .make_decoder = make_ghst_decoder,
    .make_encoder = make_ghst_encoder,
};

}  // namespace tribus
