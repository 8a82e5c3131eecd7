#include "transports/codecs/exbus/exbus.h"

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <memory>
#include <string_view>

#include "transports/codecs/crc16_8408.h"
#include "transports/codecs/wire_words.h"

namespace tribus {
namespace {

constexpr std::uint8_t kExBusFromReceiver = 0x3E;
constexpr std::uint8_t kExBusRequest = 0x3D;
constexpr std::uint8_t kExBusAnswer = 0x3B;
constexpr std::uint8_t kExBusAnswerAllowed = 0x01;
constexpr std::uint8_t kExBusAnswerForbidden = 0x03;
constexpr std::uint8_t kExBusChannels = 0x31;
constexpr std::size_t kExBusAccessAt = 1;
constexpr std::size_t kExBusLengthAt = 2;
constexpr std::size_t kExBusKindAt = 4;
constexpr std::size_t kExBusDataLengthAt = 5;
constexpr std::size_t kExBusDataAt = 6;
constexpr std::size_t kExBusCheckBytes = 2;
constexpr std::size_t kExBusLeastLength = kExBusDataAt + kExBusCheckBytes;
/// No known frame is longer than the 56 bytes of 24 channels.
constexpr std::size_t kExBusMostLength = 64;
constexpr std::size_t kExBusMostWireChannels = 24;
static_assert(kExBusLeastLength + 2 * kExBusMostWireChannels <= kExBusMostLength);

bool begins_exbus(std::uint8_t byte) {
    return byte == kExBusFromReceiver || byte == kExBusRequest || byte == kExBusAnswer;
}

bool is_exbus_access(std::uint8_t byte) {
    return byte == kExBusAnswerAllowed || byte == kExBusAnswerForbidden;
}

/// `header`: at least kExBusDataAt bytes.
bool has_exbus_channels(std::span<const std::uint8_t> header) {
    return header[0] == kExBusFromReceiver && header[kExBusKindAt] == kExBusChannels;
}

/// Whether both lengths fit each other and the kind of data. `header`: at least kExBusDataAt bytes.
bool exbus_lengths_fit(std::span<const std::uint8_t> header) {
    const std::size_t length = header[kExBusLengthAt];
    const std::size_t data = header[kExBusDataLengthAt];
    if (length > kExBusMostLength || length != kExBusLeastLength + data) {
        return false;
    }
    return !has_exbus_channels(header) ||
           (data != 0 && data % 2 == 0 && data <= 2 * kExBusMostWireChannels);
}

bool exbus_crc_holds(std::span<const std::uint8_t> frame) {
    const std::size_t body = frame.size() - kExBusCheckBytes;
    const unsigned check = frame[body] | unsigned{frame[body + 1]} << 8U;
    return crc16_8408(0, frame.first(body)) == check;
}

/// Eight words are pulses as they stand, if all of them are pulses.
bool read_eight_words(const std::uint8_t* words, std::size_t first, ChannelFrame& channels) {
    static_assert(std::endian::native == std::endian::little);
    const SignedLanes pulses = load_lanes(words);
    const auto bad = reinterpret_cast<GroupLanes>(pulses <= 0);
    if ((bad[0] | bad[1]) != 0) {
        return false;
    }
    store_numbers(&channels.pulses()[first], pulses);
    return true;
}

/// `frame` must be a whole one with channels; those that it lacks must be absent in `channels`.
void read_exbus_channels(std::span<const std::uint8_t> frame, ChannelFrame& channels) {
    const std::size_t count = std::min<std::size_t>(frame[kExBusDataLengthAt] / 2, kChannelCount);
    std::size_t read = 0;
    while (read + kLanes <= count &&
           read_eight_words(&frame[kExBusDataAt + 2 * read], read, channels)) {
        read += kLanes;
    }
    channels.mark_first(read);
    for (; read < count; ++read) {
        const std::uint8_t* const word = &frame[kExBusDataAt + 2 * read];
        const auto eighths = static_cast<std::int16_t>(word[0] | unsigned{word[1]} << 8U);
        if (eighths > 0) {
            channels.set(read, Pulse::from_eighths(eighths));
        }
    }
}

}  // namespace

ExBusDecoder::Taken ExBusDecoder::decode(std::span<const std::uint8_t> bytes, Instant received,
                                         DecodedFrame& frame) {
    // The usual case, channels in one read. The general way gives the same.
    if (buffer_.size() == 0 && bytes.size() >= kExBusLeastLength && has_exbus_channels(bytes) &&
        is_exbus_access(bytes[kExBusAccessAt]) && exbus_lengths_fit(bytes) &&
        bytes[kExBusLengthAt] <= bytes.size()) {
        const auto whole = bytes.first(bytes[kExBusLengthAt]);
        if (exbus_crc_holds(whole)) {
            frame = {.first_byte = buffer_.first_position(), .length = whole.size()};
            frame.channels.frame_lost = false;
            frame.channels.failsafe = false;
            frame.channels.received = received;
            read_exbus_channels(whole, frame.channels);
            buffer_.pass(whole.size());
            return {whole.size(), true};
        }
    }
    return FramedDecoder::decode(bytes, received, frame);
}

std::size_t ExBusDecoder::needed_bytes(std::span<const std::uint8_t> bytes) const {
    if (!begins_exbus(bytes[0]) ||
        (bytes.size() > kExBusAccessAt && !is_exbus_access(bytes[kExBusAccessAt]))) {
        return 0;
    }
    if (bytes.size() < kExBusDataAt) {
        return bytes.size() <= kExBusAccessAt ? kExBusAccessAt + 1 : kExBusDataAt;
    }
    return exbus_lengths_fit(bytes) ? bytes[kExBusLengthAt] : 0;
}

bool ExBusDecoder::check_holds(std::span<const std::uint8_t> frame) const {
    return exbus_crc_holds(frame);
}

bool ExBusDecoder::read(std::span<const std::uint8_t> frame, ChannelFrame& channels) {
    if (!has_exbus_channels(frame)) {
        return false;
    }
    read_exbus_channels(frame, channels);
    return true;
}

namespace {

constexpr std::array<std::string_view, 2> kExBusBaudChoices{"125000", "250000"};
constexpr std::array kExBusSettings{
    Setting{.key = "baud",
            .type = SettingType::integer,
            .fallback = "125000",
            .unit = "baud",
            .choices = kExBusBaudChoices,
            .of_line = true,
            .help = "Bit rate of the line: 125000, or 250000 for EX Bus HS",
            .example = "250000"},
};

AnyDecoder make_exbus_decoder(const SettingValues& /*settings*/) {
    return std::make_unique<ExBusDecoder>();
}

}  // namespace

const Protocol kExBusProtocol{
    .name = "exbus",
    .title = "EX Bus",
    .description = "Jeti EX Bus, up to 24 channels, of which the first 18 are used",
    .line = {.baud = 125000, .parity = Parity::none, .stop_bits = 1},
    .settings = kExBusSettings,
    .default_period = std::chrono::milliseconds(10),
    .signals_failsafe = never_signals_failsafe,
    .make_decoder = make_exbus_decoder,
};

}  // namespace tribus
