#include "transports/codecs/sumd/sumd.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <memory>

#include "transports/codecs/big_endian.h"
#include "transports/codecs/e2e.h"

namespace tribus {
namespace {

constexpr std::uint8_t kFirstByte = 0xA8;
constexpr std::uint8_t kLinkUp = 0x01;
constexpr std::uint8_t kLinkUpVersion3 = 0x03;
constexpr std::uint8_t kFailsafe = 0x81;
constexpr std::size_t kStatusAt = 1;
constexpr std::size_t kCountAt = 2;
constexpr std::size_t kWordsAt = 3;
constexpr std::size_t kCheckBytes = 2;
constexpr std::size_t kMostWireChannels = 32;

constexpr std::size_t frame_bytes(std::size_t channels) {
    return kWordsAt + 2 * channels + kCheckBytes;
}
static_assert(frame_bytes(kMostWireChannels) <= kLongestSerialFrame);

bool is_sumd_status(std::uint8_t status) {
    return status == kLinkUp || status == kLinkUpVersion3 || status == kFailsafe;
}

}  // namespace

std::size_t SumdDecoder::needed_bytes(std::span<const std::uint8_t> bytes) const {
    if (bytes[0] != kFirstByte || (bytes.size() > kStatusAt && !is_sumd_status(bytes[kStatusAt]))) {
        return 0;
    }
    if (bytes.size() < kWordsAt) {
        return bytes.size() + 1;
    }
    const std::size_t channels = bytes[kCountAt];
    return channels >= 1 && channels <= kMostWireChannels ? frame_bytes(channels) : 0;
}

bool SumdDecoder::check_holds(std::span<const std::uint8_t> frame) const {
    const auto body = frame.first(frame.size() - kCheckBytes);
    return crc16_1021(0, body) == big_endian_at(frame, body.size());
}

bool SumdDecoder::read(std::span<const std::uint8_t> frame, ChannelFrame& channels) {
    channels.failsafe = frame[kStatusAt] == kFailsafe;
    const std::size_t count = std::min<std::size_t>(frame[kCountAt], kChannelCount);
    for (std::size_t channel = 0; channel < count; ++channel) {
        const std::uint16_t word = big_endian_at(frame, kWordsAt + 2 * channel);
        if (word != 0) {
            channels.set(channel, Pulse::from_eighths(word));
        }
    }
    return true;
}

std::uint32_t SumdEncoder::needed_channels(const ChannelFrame& /*frame*/) const {
    return first_channels(channels_);
}

std::size_t SumdEncoder::write(const ChannelFrame& frame,
                               std::span<std::uint8_t, kLongestSerialFrame> wire, Instant /*now*/) {
    wire[0] = kFirstByte;
    wire[kStatusAt] = frame.failsafe ? kFailsafe : kLinkUp;
    wire[kCountAt] = static_cast<std::uint8_t>(channels_);
    for (std::size_t channel = 0; channel < channels_; ++channel) {
        const auto pulse = frame.channel(channel);
        const std::int32_t eighths = pulse ? std::max(pulse->eighths(), 1) : 0;
        put_big_endian(wire, kWordsAt + 2 * channel, static_cast<std::uint16_t>(eighths));
    }
    const std::size_t body = kWordsAt + 2 * channels_;
    put_big_endian(wire, body, crc16_1021(0, wire.first(body)));
    return body + kCheckBytes;
}

namespace {

constexpr std::array kSumdSettings{
    baud_setting("115200", "115200"),
    Setting{.key = "channels",
            .type = SettingType::integer,
            .fallback = "16",
            .least = 1,
            .most = kChannelCount,
            .scope = SettingScope::output,
            .help = "How many channels are sent",
            .example = "12"},
};

constexpr std::array kSumdBeginnings{FrameBeginning{kFirstByte, kLinkUp},
                                     FrameBeginning{kFirstByte, kLinkUpVersion3},
                                     FrameBeginning{kFirstByte, kFailsafe}};

AnyDecoder make_sumd_decoder(const SettingValues& /*settings*/) {
    return std::make_unique<SumdDecoder>();
}

AnyEncoder make_sumd_encoder(const SettingValues& settings) {
    return std::make_unique<SumdEncoder>(
        static_cast<std::size_t>(settings.get_or<std::int64_t>("channels", 16)));
}

}  // namespace

// Real receivers send each 10 ms (PX4's recording: 9.98 to 10.57 ms); Betaflight takes 4 ms of
// silence for the end of a frame.
const Protocol kSumdProtocol{
    .name = "sumd",
    .title = "SUMD",
    .description = "Graupner HoTT SUMD, up to 32 channels, of which the first 18 are used",
    .line = {.baud = 115200, .parity = Parity::none, .stop_bits = 1},
    .beginnings = kSumdBeginnings,
    .settings = kSumdSettings,
    .longest_frame = frame_bytes(kChannelCount),
    .default_period = std::chrono::milliseconds(10),
    .least_period = std::chrono::milliseconds(8),
    .signals_failsafe = always_signals_failsafe,
    .make_decoder = make_sumd_decoder,
    .make_encoder = make_sumd_encoder,
};

}  // namespace tribus
