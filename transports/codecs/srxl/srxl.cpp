#include "transports/codecs/srxl/srxl.h"

#include <algorithm>
#include <array>
#include <bit>

#include "transports/codecs/big_endian.h"
#include "transports/codecs/crc.h"
#include "transports/codecs/wire_words.h"

namespace tribus {
namespace {

constexpr std::uint8_t kSrxlVersion1 = 0xA1;
constexpr std::uint8_t kSrxlVersion2 = 0xA2;
constexpr std::uint8_t kSrxlVersion5 = 0xA5;
constexpr std::size_t kSrxlCheckBytes = 2;
constexpr std::size_t kSrxlNarrowChannels = 12;
constexpr std::size_t kSrxlWideChannels = 16;
constexpr std::size_t kSrxlNumberedWords = 7;

/// Length of a frame with this first byte; 0 if none begins so.
constexpr std::size_t srxl_length(std::uint8_t first) {
    switch (first) {
        case kSrxlVersion1:
            return 1 + 2 * kSrxlNarrowChannels + kSrxlCheckBytes;
        case kSrxlVersion2:
            return 1 + 2 * kSrxlWideChannels + kSrxlCheckBytes;
        case kSrxlVersion5:
            return 2 + 2 * kSrxlNumberedWords + kSrxlCheckBytes;
        default:
            return 0;
    }
}
static_assert(srxl_length(kSrxlVersion2) == kSrxlMostBytes);

/// The check of a frame of any version.
std::uint16_t srxl_crc(const std::uint8_t* frame) {
    const auto of = [frame]<std::size_t length>() {
        constexpr std::size_t kBody = length - kSrxlCheckBytes;
        return Crc<std::uint16_t, 0x1021>::of(0,
                                              std::span<const std::uint8_t, kBody>(frame, kBody));
    };
    switch (frame[0]) {
        case kSrxlVersion1:
            return of.operator()<srxl_length(kSrxlVersion1)>();
        case kSrxlVersion2:
            return of.operator()<srxl_length(kSrxlVersion2)>();
        default:
            return of.operator()<srxl_length(kSrxlVersion5)>();
    }
}

// Versions 1 and 2: 800 us + raw x 1400 us / 4096 (docs/protocols/srxl.md, "Versions 1 and 2"). In
// eighths the step is 175 / 64.
constexpr std::uint16_t kSrxlRawMost = 0x0FFF;
constexpr std::int16_t kSrxlLeastEighths = 800 * 8;
constexpr std::int16_t kSrxlMostEighths = kSrxlLeastEighths + (kSrxlRawMost * 175 + 32) / 64;

/// Turns eight words of the wire into raw values. The upper four bits are not used.
Lanes srxl_raws(const std::uint8_t* words) {
    static_assert(std::endian::native == std::endian::little);
    const auto swapped = reinterpret_cast<Lanes>(load_lanes(words));
    return (swapped << 8U | swapped >> 8U) & kSrxlRawMost;
}

/// The pulses of eight raw values, to the nearest eighth.
SignedLanes srxl_eighths(Lanes raws) {
    // Twice 175 / 64, times 2^12; a raw value is shifted by the other four bits.
    constexpr std::uint32_t kTwoSteps = 2 * 175 * (1U << 12U) / 64;
    auto eighths = std::bit_cast<std::array<std::uint16_t, kLanes>>(raws << 4U);
    for (std::uint16_t& number : eighths) {
        number = static_cast<std::uint16_t>((number * kTwoSteps) >> 16U);
    }
    return reinterpret_cast<SignedLanes>(((std::bit_cast<Lanes>(eighths) + 1) >> 1U) +
                                         kSrxlLeastEighths);
}

/// The nearest raw value.
std::uint16_t srxl_raw(std::int16_t eighths) {
    // 64 / 175 in 2^20ths: exact enough for all pulses, and the product has 32 bits.
    constexpr std::uint32_t kPerStep = 383479;
    constexpr std::uint32_t kHalf = 1U << 19U;
    const std::int16_t inside = std::clamp(eighths, kSrxlLeastEighths, kSrxlMostEighths);
    const auto above = static_cast<std::uint32_t>(inside - kSrxlLeastEighths);
    return static_cast<std::uint16_t>((above * kPerStep + kHalf) >> 20U);
}

/// Version 5: (value - 1024) x 500 us / 876 + 1500 us.
Pulse srxl_word_pulse(std::uint16_t word) {
    constexpr std::int32_t kValueBits = 0x7FF;
    constexpr std::int32_t kCentre = 1024;
    // 4000 / 876 eighths a step. The positive number under the division makes it round to nearest.
    constexpr std::int32_t kNumerator = 1000;
    constexpr std::int32_t kDenominator = 219;
    const std::int32_t steps = (word & kValueBits) - kCentre;
    constexpr std::int32_t kCentreEighths = 1500 * 8;
    return Pulse::from_eighths(
        (steps * kNumerator + kCentreEighths * kDenominator + kDenominator / 2) / kDenominator);
}

}  // namespace

[[gnu::flatten]] SrxlDecoder::Taken SrxlDecoder::decode(std::span<const std::uint8_t> bytes,
                                                        Instant received, DecodedFrame& frame) {
    // The usual case, a frame in one read. The general way gives the same.
    if (buffer_.size() == 0 && !bytes.empty()) {
        const std::size_t length = srxl_length(bytes[0]);
        if (length != 0 && bytes.size() >= length && check_holds(bytes.first(length))) {
            frame = {.first_byte = buffer_.first_position(), .length = length};
            frame.channels.frame_lost = false;
            frame.channels.failsafe = false;
            frame.channels.received = received;
            buffer_.pass(length);
            return {length, read(bytes.first(length), frame.channels)};
        }
    }
    return FramedDecoder::decode(bytes, received, frame);
}

std::size_t SrxlDecoder::needed_bytes(std::span<const std::uint8_t> bytes) const {
    return srxl_length(bytes[0]);
}

bool SrxlDecoder::check_holds(std::span<const std::uint8_t> frame) const {
    const std::size_t body = frame.size() - kSrxlCheckBytes;
    return srxl_crc(frame.data()) == big_endian_at(frame, body);
}

bool SrxlDecoder::read(std::span<const std::uint8_t> frame, ChannelFrame& channels) {
    version_[0] = frame[0] & 0x0FU;
    if (frame[0] == kSrxlVersion5) {
        read_words(frame, channels);
    } else {
        read_all(&frame[1], (frame.size() - 1 - kSrxlCheckBytes) / 2, channels);
    }
    return true;
}

/// Versions 1 and 2. Of 12 channels the two groups of eight have four in common.
void SrxlDecoder::read_all(const std::uint8_t* words, std::size_t count, ChannelFrame& channels) {
    raw_count_ = count;
    for (const std::size_t first : {std::size_t{0}, count - kLanes}) {
        const Lanes raws = srxl_raws(words + 2 * first);
        store_numbers(&raw_[first], reinterpret_cast<SignedLanes>(raws));
        store_numbers(&channels.pulses()[first], srxl_eighths(raws));
    }
    channels.mark_first(count);
}

/// A word: one bit, which marks words of an unknown kind, four bits for the channel's number, and
/// 11 for its value. Numbers above 11 are those of the X-Plus channels, whose form no public source
/// confirms.
void SrxlDecoder::read_words(std::span<const std::uint8_t> frame, ChannelFrame& channels) {
    constexpr std::size_t kFlagsAt = 1;
    constexpr std::size_t kWordsAt = 2;
    constexpr unsigned kConnected = 0x02;
    channels.failsafe = (frame[kFlagsAt] & kConnected) == 0;
    raw_count_ = kSrxlNumberedWords;
    for (std::size_t i = 0; i < kSrxlNumberedWords; ++i) {
        const std::uint16_t word = big_endian_at(frame, kWordsAt + 2 * i);
        raw_[i] = word;
        const std::size_t channel = word >> 11U;
        if (channel < words_.size()) {
            words_[channel] = {srxl_word_pulse(word), channels.received};
        }
    }
    for (std::size_t channel = 0; channel < words_.size(); ++channel) {
        const WordChannel& latest = words_[channel];
        if (latest.received && channels.received - *latest.received <= kWordLasts) {
            channels.set(channel, latest.pulse);
        }
    }
}

std::span<const FrameDetail> SrxlDecoder::details() const {
    if (raw_count_ == 0) {
        return {};
    }
    details_ = {FrameDetail{"version", version_, false},
                FrameDetail{"raw", std::span(raw_).first(raw_count_), true}};
    return details_;
}

std::uint32_t SrxlEncoder::needed_channels(const ChannelFrame& /*frame*/) const {
    return first_channels(kSrxlWideChannels);
}

std::size_t SrxlEncoder::write(const ChannelFrame& frame,
                               std::span<std::uint8_t, kLongestSerialFrame> wire, Instant now) {
    if (!frame.has_first(kSrxlWideChannels)) {
        ChannelFrame filled = frame;
        for (std::size_t channel = 0; channel < kSrxlWideChannels; ++channel) {
            filled.set(channel, frame.channel_or(channel, kCentrePulse));
        }
        return write(filled, wire, now);
    }
    constexpr std::size_t kBody = kSrxlMostBytes - kSrxlCheckBytes;
    std::array<std::uint16_t, kSrxlWideChannels> words;
    for (std::size_t channel = 0; channel < words.size(); ++channel) {
        const auto eighths = static_cast<std::int16_t>(frame.pulses()[channel].eighths());
        words[channel] = srxl_raw(eighths);
    }
    wire[0] = kSrxlVersion2;
    for (std::size_t first = 0; first < words.size(); first += kLanes) {
        const auto raws = reinterpret_cast<Lanes>(load_lanes(&words[first]));
        store_numbers(&wire[1 + 2 * first], reinterpret_cast<SignedLanes>(raws << 8U | raws >> 8U));
    }
    put_big_endian(wire, kBody, srxl_crc(wire.data()));
    return kSrxlMostBytes;
}

}  // namespace tribus
