#include <array>
#include <memory>

#include "transports/codecs/ibus2/ibus2.h"

namespace tribus {
namespace {

constexpr std::array kIbus2Settings{baud_setting("1500000", "1500000", 1.5e6)};

AnyDecoder make_ibus2_decoder(const SettingValues& /*settings*/) {
    return std::make_unique<Ibus2Decoder>();
}

}  // namespace

const Protocol kIbus2Protocol{
    .name = "ibus2",
    .title = "i-BUS2",
    .description =
        "FlySky i-BUS2 of AFHDS 3 receivers as input, by listening: the first 18 "
        "channels",
    .line = {.baud = 1500000, .parity = Parity::none, .stop_bits = 1},
    .settings = kIbus2Settings,
    .signals_failsafe = always_signals_failsafe,
    .make_decoder = make_ibus2_decoder,
};

}  // namespace tribus
