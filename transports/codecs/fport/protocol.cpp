#include <array>
#include <cstddef>
#include <memory>

#include "transports/codecs/fport/fport.h"
#include "transports/codecs/sbus/settings.h"

namespace tribus {
namespace {

constexpr std::array kFportSettings{baud_setting("115200", "115200"), kSbusScaleSetting,
                                    kInvertedSetting};
constexpr std::array kFbusSettings{baud_setting("460800", "460800"), kSbusScaleSetting,
                                   kInvertedSetting};

constexpr LineSettings kFportLine{
    .baud = 115200, .parity = Parity::none, .stop_bits = 1, .inverted_wire = true};
constexpr LineSettings kFbusLine{
    .baud = 460800, .parity = Parity::none, .stop_bits = 1, .inverted_wire = true};

constexpr std::array kFportBeginnings{FrameBeginning{0x7E, 0x19}};
/// By the number of channels.
constexpr std::array kFport2Beginnings{FrameBeginning{0x18, 0xFF}, FrameBeginning{0x0D, 0xFF},
                                       FrameBeginning{0x23, 0xFF}};

template <class Decoder>
AnyDecoder make_fport_decoder(const SettingValues& settings) {
    return std::make_unique<Decoder>(SbusScale::from_setting(settings.find("scale")));
}

/// FrSky's receivers send raw 0 in SBUS for "no pulses", so the same is expected here
/// (docs/protocols/fport.md, "Loss").
Pulse fport_raw_zero(const SettingValues& settings) {
    return SbusScale::from_setting(settings.find("scale")).decode(0);
}

}  // namespace

const Protocol kFportProtocol{
    .name = "fport",
    .title = "F.Port",
    .description = "FrSky F.Port (version 1) as input, 16 channels",
    .line = kFportLine,
    .beginnings = kFportBeginnings,
    .settings = kFportSettings,
    .signals_failsafe = always_signals_failsafe,
    .raw_zero = fport_raw_zero,
    .sure_channels = always_has_first<kSbusChannels>,
    .make_decoder = make_fport_decoder<FportDecoder>,
};

const Protocol kFport2Protocol{
    .name = "fport2",
    .title = "F.Port 2",
    .description = "FrSky F.Port 2 as input, up to 24 channels, of which the first 18 are used",
    .line = kFportLine,
    .beginnings = kFport2Beginnings,
    .settings = kFportSettings,
    .signals_failsafe = always_signals_failsafe,
    .raw_zero = fport_raw_zero,
    .sure_channels = always_has_first<8>,
    .make_decoder = make_fport_decoder<Fport2Decoder>,
};

const Protocol kFbusProtocol{
    .name = "fbus",
    .title = "FBUS",
    .description = "FrSky FBUS as input: F.Port 2 at 460800 baud",
    .line = kFbusLine,
    .beginnings = kFport2Beginnings,
    .settings = kFbusSettings,
    .signals_failsafe = always_signals_failsafe,
    .raw_zero = fport_raw_zero,
    .sure_channels = always_has_first<8>,
    .make_decoder = make_fport_decoder<Fport2Decoder>,
};

}  // namespace tribus
