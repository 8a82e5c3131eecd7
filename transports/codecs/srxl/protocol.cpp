#include <array>
#include <chrono>
#include <memory>

#include "transports/codecs/srxl/srxl.h"

namespace tribus {
namespace {

constexpr std::array kSrxlSettings{baud_setting("115200", "115200")};

constexpr std::array kSrxlBeginnings{FrameBeginning{0xA1}, FrameBeginning{0xA2},
                                     FrameBeginning{0xA5}};

AnyDecoder make_srxl_decoder(const SettingValues& /*settings*/) {
    return std::make_unique<SrxlDecoder>();
}

AnyEncoder make_srxl_encoder(const SettingValues& /*settings*/) {
    return std::make_unique<SrxlEncoder>();
}

}  // namespace

// Receivers of Multiplex send each 14 or 21 ms. ArduPilot finds a frame by 8 ms of silence before
// it, and a frame takes 3 ms.
const Protocol kSrxlProtocol{
    .name = "srxl",
    .title = "SRXL",
    .description = "SRXL of Multiplex (JR XBus mode B), up to 16 channels, and of Spektrum",
    .line = {.baud = 115200, .parity = Parity::none, .stop_bits = 1},
    .beginnings = kSrxlBeginnings,
    .settings = kSrxlSettings,
    .longest_frame = kSrxlMostBytes,
    .default_period = std::chrono::milliseconds(14),
    .least_period = std::chrono::milliseconds(12),
    .signals_failsafe = never_signals_failsafe,
    .make_decoder = make_srxl_decoder,
    .make_encoder = make_srxl_encoder,
};

}  // namespace tribus
