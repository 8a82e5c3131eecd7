#include "transports/codecs/sbus/sbus.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <numeric>
#include <string_view>

#include "transports/codecs/sbus/settings.h"
#include "transports/codecs/sbus/wire.h"

namespace tribus {

using namespace sbus_wire;

namespace {

/// Centres the absent channels. An absent switch is off, since the pulse of an absent channel is 0.
ChannelFrame filled_sbus(const ChannelFrame& frame) {
    constexpr Lanes kFirst{1U << 0U, 1U << 1U, 1U << 2U, 1U << 3U,
                           1U << 4U, 1U << 5U, 1U << 6U, 1U << 7U};
    constexpr auto kCentre = static_cast<std::int16_t>(kCentrePulse.eighths());
    ChannelFrame full = frame;
    full.mark_first(kChannelCount);
    for (std::size_t first = 0; first < kSbusChannels; first += kLanes) {
        Pulse* pulses = full.pulses().data() + first;
        const Lanes absent = Lanes{} + static_cast<std::uint16_t>(frame.absent() >> first);
        const SignedLanes missing = (absent & kFirst) == kFirst;
        store_numbers(pulses, load_lanes(pulses) | (missing & kCentre));
    }
    return full;
}

inline unsigned wire_flags(bool channel_17, bool channel_18, bool frame_lost, bool failsafe) {
    return unsigned{channel_17} * kChannel17Flag + unsigned{channel_18} * kChannel18Flag +
           unsigned{frame_lost} * kFrameLostFlag + unsigned{failsafe} * kFailsafeFlag;
}

/// `frame` must have all channels.
inline void write_frame(const SbusRaw& raw, const ChannelFrame& frame,
                        std::span<std::uint8_t, kSbusFrameLength> wire) {
    const bool channel_17 = frame.pulses()[16] > kCentrePulse;
    const bool channel_18 = frame.pulses()[17] > kCentrePulse;
    pack(raw, wire_flags(channel_17, channel_18, frame.frame_lost, frame.failsafe), 0, wire);
}

}  // namespace

SbusFrame parse_sbus(std::span<const std::uint8_t, kSbusFrameLength> wire) {
    SbusFrame frame;
    frame.raw = from_lanes(unpack(wire));
    const std::uint8_t flags = wire[kFlagsAt];
    frame.channel_17 = (flags & kChannel17Flag) != 0;
    frame.channel_18 = (flags & kChannel18Flag) != 0;
    frame.frame_lost = (flags & kFrameLostFlag) != 0;
    frame.failsafe = (flags & kFailsafeFlag) != 0;
    frame.footer = wire[kFooterAt];
    return frame;
}

void emit_sbus(const SbusFrame& frame, std::span<std::uint8_t, kSbusFrameLength> wire) {
    SbusRaw raw = frame.raw;
    for (std::uint16_t& value : raw) {
        value &= kSbusRawMost;
    }
    const unsigned flags =
        wire_flags(frame.channel_17, frame.channel_18, frame.frame_lost, frame.failsafe);
    pack(raw, flags, frame.footer, wire);
}

std::size_t SbusEncoder::write(const ChannelFrame& frame,
                               std::span<std::uint8_t, kLongestSerialFrame> wire, Instant /*now*/) {
    if (frame.has_first(kChannelCount) && scale_.whole_steps()) {
        write_frame(scale_.encode_whole(frame), frame, wire.first<kSbusFrameLength>());
        return kSbusFrameLength;
    }
    return encode_any(frame, wire);
}

std::size_t SbusEncoder::encode_any(const ChannelFrame& frame,
                                    std::span<std::uint8_t, kLongestSerialFrame> wire) const {
    const ChannelFrame full = filled_sbus(frame);
    write_frame(scale_.whole_steps() ? scale_.encode_whole(full) : scale_.encode_each(full), full,
                wire.first<kSbusFrameLength>());
    return kSbusFrameLength;
}

namespace {

constexpr std::array<std::string_view, 2> kBaudChoices{"100000", "200000"};
constexpr std::array kSbusSettings{
    Setting{.key = "baud",
            .type = SettingType::integer,
            .fallback = "100000",
            .unit = "baud",
            .choices = kBaudChoices,
            .of_line = true,
            .help = "Bit rate of the line: 100000, or 200000 for the fast variant (DJI)",
            .example = "200000"},
    kSbusScaleSetting,
    kInvertedSetting,
};

constexpr std::array kSbusBeginnings{FrameBeginning{0x0F}};

AnyDecoder make_sbus_decoder(const SettingValues& settings) {
    return std::make_unique<SbusDecoder>(SbusScale::from_setting(settings.find("scale")));
}

AnyEncoder make_sbus_encoder(const SettingValues& settings) {
    return std::make_unique<SbusEncoder>(SbusScale::from_setting(settings.find("scale")));
}

Pulse raw_zero(const SettingValues& settings) {
    return SbusScale::from_setting(settings.find("scale")).decode(0);
}

}  // namespace

// 14 ms is Futaba's normal mode, which analogue servos tolerate. Below 7 ms a frame leaves less
// than the 4 ms of silence that ArduPilot waits for (docs/protocols/sbus.md, "Periods" and
// "Synchronisation"). 6 ms, which EdgeTX sends too, leaves the 3 ms that INAV waits for; ArduPilot
// then misses the frame that comes early.
const Protocol kSbusProtocol{
    .name = "sbus",
    .title = "SBUS",
    .description = "Futaba SBUS, and SBUS2 frames as input",
    .line = {.baud = 100000, .parity = Parity::even, .stop_bits = 2, .inverted_wire = true},
    .beginnings = kSbusBeginnings,
    .settings = kSbusSettings,
    .longest_frame = kSbusFrameLength,
    .default_period = std::chrono::milliseconds(14),
    .least_period = std::chrono::milliseconds(7),
    .least_spacing = std::chrono::milliseconds(6),
    .signals_failsafe = always_signals_failsafe,
    .raw_zero = raw_zero,
    .sure_channels = always_has_first<kChannelCount>,
    .make_decoder = make_sbus_decoder,
    .make_encoder = make_sbus_encoder,
};

/// Number of bytes in which the frame at `start` equals the last one that is beyond doubt. The
/// footer does not count, since it cycles in SBUS2.
int SbusDecoder::likeness(std::size_t start) const {
    const auto bytes = buffer_.view(start, kFooterAt);
    return std::inner_product(bytes.begin(), bytes.end(), trusted().begin(), 0, std::plus<>{},
                              std::equal_to<>{});
}

void SbusDecoder::scale_each(ChannelFrame& channels) const {
    scale_.decode_each(from_lanes(unpack(latest())), channels);
}

std::span<const FrameDetail> SbusDecoder::details() const {
    raw_ = from_lanes(unpack(latest()));
    footer_[0] = latest()[kFooterAt];
    return details_;
}

}  // namespace tribus
