#include "transports/codecs/msp/msp.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <memory>

#include "transports/codecs/crc8_d5.h"
#include "transports/codecs/microsecond_words.h"

namespace tribus {

using microsecond_words::microseconds_at;
using microsecond_words::microseconds_of;
using microsecond_words::pulse_of;
using microsecond_words::put_microseconds;

namespace {

constexpr std::uint8_t kDollar = 0x24;
constexpr std::uint8_t kLetterM = 0x4D;
constexpr std::uint8_t kLetterX = 0x58;
/// Towards the flight controller; answers have '>'.
constexpr std::uint8_t kRequest = 0x3C;
constexpr std::size_t kLetterAt = 1;
constexpr std::size_t kBeginningBytes = 3;
constexpr std::array<std::uint8_t, kBeginningBytes> kBeginning{kDollar, kLetterM, kRequest};
constexpr std::size_t kSizeAt = kBeginningBytes;
constexpr std::size_t kCommandAt = kSizeAt + 1;
constexpr std::size_t kContentAt = kCommandAt + 1;
constexpr std::uint8_t kSetRawRc = 200;
/// Longer messages set other things; their bytes are skipped.
constexpr std::size_t kLongestContent = 64;

constexpr std::size_t message_bytes(std::size_t content) {
    return kContentAt + content + 1;
}
static_assert(2 * kChannelCount <= kLongestContent);

/// Version 2: a flag, the command and the size in two bytes each, the low byte first.
constexpr std::size_t kFlagAt = kBeginningBytes;
constexpr std::size_t kLongCommandAt = kFlagAt + 1;
constexpr std::size_t kLongSizeAt = kLongCommandAt + 2;
constexpr std::size_t kLongContentAt = kLongSizeAt + 2;
static_assert(kLongContentAt + kLongestContent + 1 <= kLongestSerialFrame);

/// XOR of all behind the beginning.
std::uint8_t check_of(std::span<const std::uint8_t> message) {
    std::uint8_t check = 0;
    for (const std::uint8_t byte : message.subspan(kSizeAt)) {
        check ^= byte;
    }
    return check;
}

bool is_version_2(std::span<const std::uint8_t> frame) {
    return frame[kLetterAt] == kLetterX;
}

bool may_begin(std::span<const std::uint8_t> bytes) {
    return bytes[0] == kDollar &&
           (bytes.size() <= kLetterAt || bytes[kLetterAt] == kLetterM || is_version_2(bytes)) &&
           (bytes.size() < kBeginningBytes || bytes[kBeginningBytes - 1] == kRequest);
}

std::size_t needed_of_version_2(std::span<const std::uint8_t> bytes) {
    if (bytes.size() < kLongContentAt) {
        return bytes.size() + 1;
    }
    const std::size_t content = microseconds_at(bytes, kLongSizeAt);
    return content <= kLongestContent ? kLongContentAt + content + 1 : 0;
}

/// The content of MSP_SET_RAW_RC. Empty for other commands.
std::span<const std::uint8_t> raw_rc_of(std::span<const std::uint8_t> frame) {
    const bool version_2 = is_version_2(frame);
    const std::size_t command =
        version_2 ? microseconds_at(frame, kLongCommandAt) : frame[kCommandAt];
    const std::size_t content_at = version_2 ? kLongContentAt : kContentAt;
    return command == kSetRawRc ? frame.subspan(content_at, frame.size() - content_at - 1)
                                : std::span<const std::uint8_t>{};
}

}  // namespace

std::size_t MspDecoder::needed_bytes(std::span<const std::uint8_t> bytes) const {
    if (!may_begin(bytes)) {
        return 0;
    }
    if (bytes.size() <= kSizeAt) {
        return bytes.size() + 1;
    }
    if (is_version_2(bytes)) {
        return needed_of_version_2(bytes);
    }
    return bytes[kSizeAt] <= kLongestContent ? message_bytes(bytes[kSizeAt]) : 0;
}

/// With the check itself the result is 0.
bool MspDecoder::check_holds(std::span<const std::uint8_t> frame) const {
    return is_version_2(frame) ? Crc8D5::of(0, frame.subspan(kFlagAt)) == 0 : check_of(frame) == 0;
}

bool MspDecoder::read(std::span<const std::uint8_t> frame, ChannelFrame& channels) {
    const auto content = raw_rc_of(frame);
    const std::size_t words = content.size() / 2;
    if (content.size() % 2 != 0 || words == 0) {
        return false;
    }
    for (std::size_t channel = 0; channel < std::min(words, kChannelCount); ++channel) {
        if (const auto pulse = pulse_of(microseconds_at(content, 2 * channel))) {
            channels.set(channel, *pulse);
        }
    }
    return true;
}

std::uint32_t MspEncoder::needed_channels(const ChannelFrame& /*frame*/) const {
    return first_channels(channels_);
}

std::size_t MspEncoder::write(const ChannelFrame& frame,
                              std::span<std::uint8_t, kLongestSerialFrame> wire, Instant /*now*/) {
    std::ranges::copy(kBeginning, wire.begin());
    wire[kSizeAt] = static_cast<std::uint8_t>(2 * channels_);
    wire[kCommandAt] = kSetRawRc;
    for (std::size_t channel = 0; channel < channels_; ++channel) {
        put_microseconds(wire, kContentAt + 2 * channel, microseconds_of(frame, channel));
    }
    const std::size_t length = message_bytes(2 * channels_);
    wire[length - 1] = check_of(wire.first(length - 1));
    return length;
}

namespace {

constexpr std::array kMspSettings{
    baud_setting("115200", "115200"),
    Setting{.key = "channels",
            .type = SettingType::integer,
            .fallback = "16",
            .least = 1,
            .most = kChannelCount,
            .scope = SettingScope::output,
            .help = "How many channels are sent",
            .example = "8"},
};

constexpr std::array kMspBeginnings{FrameBeginning{kDollar, kLetterM},
                                    FrameBeginning{kDollar, kLetterX}};

AnyDecoder make_msp_decoder(const SettingValues& /*settings*/) {
    return std::make_unique<MspDecoder>();
}

AnyEncoder make_msp_encoder(const SettingValues& settings) {
    return std::make_unique<MspEncoder>(
        static_cast<std::size_t>(settings.get_or<std::int64_t>("channels", 16)));
}

}  // namespace

// 25 to 50 messages a second work well with Betaflight; from 2026.6 on it waits 300 ms for the
// next.
const Protocol kMspProtocol{
    .name = "msp",
    .title = "MSP",
    .description = "MSP_SET_RAW_RC of MSP, to flight controllers with Betaflight or INAV",
    .line = {.baud = 115200, .parity = Parity::none, .stop_bits = 1},
    .beginnings = kMspBeginnings,
    .settings = kMspSettings,
    .longest_frame = message_bytes(2 * kChannelCount),
    .default_period = std::chrono::milliseconds(20),
    .least_period = std::chrono::milliseconds(5),
    .default_timeout = std::chrono::milliseconds(300),
    .signals_failsafe = never_signals_failsafe,
    .make_decoder = make_msp_decoder,
    .make_encoder = make_msp_encoder,
};

}  // namespace tribus
