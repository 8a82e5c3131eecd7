#include "transports/codecs/exbus/exbus.h"

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <memory>

#include "transports/codecs/exbus/wire.h"
#include "transports/codecs/wire_words.h"

namespace tribus {

namespace {

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
    return ExBusCrc::of(0, frame.first(body)) == check;
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

std::size_t ExBusFrames::needed_bytes(std::span<const std::uint8_t> bytes) const {
    if (!begins_exbus(bytes[0]) ||
        (bytes.size() > kExBusAccessAt && !is_exbus_access(bytes[kExBusAccessAt]))) {
        return 0;
    }
    if (bytes.size() < kExBusDataAt) {
        return bytes.size() <= kExBusAccessAt ? kExBusAccessAt + 1 : kExBusDataAt;
    }
    return exbus_lengths_fit(bytes) ? bytes[kExBusLengthAt] : 0;
}

bool ExBusFrames::check_holds(std::span<const std::uint8_t> frame) const {
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

constexpr std::array kExBusSettings{kExBusBaudSetting};

AnyDecoder make_exbus_decoder(const SettingValues& /*settings*/) {
    return std::make_unique<ExBusDecoder>();
}

}  // namespace

const Protocol kExBusProtocol{
    .name = "exbus",
    .title = "EX Bus",
    .description = "Jeti EX Bus, up to 24 channels, of which the first 18 are used",
    .line = kExBusLine,
    .settings = kExBusSettings,
    .default_period = std::chrono::milliseconds(10),
    .signals_failsafe = never_signals_failsafe,
    .make_decoder = make_exbus_decoder,
};

}  // namespace tribus
