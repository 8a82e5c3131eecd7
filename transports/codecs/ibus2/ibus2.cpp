#include "transports/codecs/ibus2/ibus2.h"

#include <algorithm>
#include <cstring>
#include <tuple>

#include "transports/codecs/ibus/ibus2_frame.h"
#include "transports/codecs/sbus/packed_channels.h"
#include "transports/codecs/wire_words.h"

namespace tribus {

namespace {

constexpr std::uint8_t kIbus2Command = 1;
constexpr std::uint8_t kIbus2Reply = 2;
constexpr unsigned kIbus2CommandShift = 2;
constexpr std::uint8_t kLastCommand = 4;
constexpr std::size_t kCommandFrame = 21;

constexpr std::uint8_t kChannelsSubtype = 0;
constexpr std::uint8_t kKeySubtype = 1;
constexpr std::uint8_t kSyncLost = 0x40;
constexpr std::uint8_t kIbus2Failsafe = 0x80;

constexpr std::size_t kIbus2LengthAt = 1;
constexpr std::size_t kIbus2AddressAt = 2;
constexpr std::size_t kPackedAt = 3;
constexpr std::size_t kLeastIbus2Length = kPackedAt + 1;
constexpr std::size_t kMostPacked = ibus2_frame::kLongest - kLeastIbus2Length;

/// All devices: the first level of the address is 7, and the two highest bits are 0.
constexpr std::uint8_t kIbus2AddressMask = 0xC7;
constexpr std::uint8_t kAllDevices = 0x07;

constexpr std::size_t kWireChannels = 32;
constexpr unsigned kTypeBits = 5;
constexpr std::size_t kKeyBytes = kWireChannels * kTypeBits / 8;
constexpr unsigned kBitsOfType = 0x0F;
constexpr unsigned kElevenBits = 11;

/// FlySky limits values to 150 %, which are 750 us from 1500.
constexpr std::int32_t kMostEighths = 750 * 8;

/// Step of each type in eighths; 0 for those that have no meaning (docs/protocols/ibus2.md, "Key").
/// Their low four bits are the number of bits.
constexpr std::array<std::int16_t, 32> kStepEighths = [] {
    std::array<std::int16_t, 32> steps{};
    steps[0x02] = 4000;
    steps[0x13] = 2000;
    steps[0x14] = 1000;
    steps[0x15] = 400;
    steps[0x16] = 200;
    steps[0x06] = 160;
    steps[0x07] = 80;
    steps[0x18] = 80;
    steps[0x08] = 32;
    steps[0x19] = 40;
    steps[0x09] = 16;
    steps[0x1A] = 16;
    steps[0x0A] = 8;
    steps[0x1B] = 8;
    steps[0x0B] = 4;
    steps[0x1C] = 4;
    steps[0x0C] = 2;
    steps[0x1D] = 2;
    steps[0x0D] = 1;
    return steps;
}();

/// The least value of so many bits. The lowest number is "keep the last"; with 6 bits and more, the
/// next one is "stop".
constexpr std::int16_t least_ibus2_value(unsigned bits) {
    constexpr unsigned kStopFromBits = 6;
    return static_cast<std::int16_t>(-(1 << (bits - 1)) + (bits >= kStopFromBits ? 2 : 1));
}

}  // namespace

inline void Ibus2Decoder::unpack_one(const Padded& padded, std::size_t channel,
                                     ChannelFrame& channels) const {
    constexpr unsigned kWordBits = 64;
    const Place& place = key_.channels[channel];
    if (place.step_eighths == 0) {
        return;
    }
    // The highest bit of the value becomes the sign.
    const std::uint64_t on_top = load_word(&padded[place.byte])
                                 << (kWordBits - place.bits - place.shift);
    const auto value =
        static_cast<std::int32_t>(static_cast<std::int64_t>(on_top) >> (kWordBits - place.bits));
    if (value >= place.least) {
        const std::int32_t eighths =
            std::clamp(value * place.step_eighths, -kMostEighths, kMostEighths);
        channels.set(channel, Pulse::from_eighths(kCentrePulse.eighths() + eighths));
    }
}

/// Channels of 11 bits are packed as those of SBUS. Returns false and changes nothing if one of
/// them has no value.
inline bool Ibus2Decoder::unpack_alike(const Padded& padded, ChannelFrame& channels) const {
    constexpr unsigned kUnusedBits = 16 - kElevenBits;
    constexpr auto kMost = static_cast<std::int16_t>(kMostEighths);
    constexpr auto kCentre = static_cast<std::int16_t>(kCentrePulse.eighths());
    const Key& key = key_;
    const Place& place = key.channels[0];
    const SbusLanes raw = unpack_channels(std::span(padded).first<kPackedChannelBytes>());
    const std::uint64_t beyond = load_word(&padded[kPackedChannelBytes]);
    const Lanes rest{static_cast<std::uint16_t>(beyond),
                     static_cast<std::uint16_t>(beyond >> kElevenBits)};
    // The highest bit of a value becomes the sign.
    const auto values = [](Lanes lanes) {
        return reinterpret_cast<SignedLanes>(lanes << kUnusedBits) >> kUnusedBits;
    };
    const std::array<SignedLanes, 3> all{values(raw.first), values(raw.last), values(rest)};
    using Halves [[gnu::vector_size(16)]] = std::uint64_t;
    const auto none = reinterpret_cast<Halves>(((all[0] < place.least) & key.used[0]) |
                                               ((all[1] < place.least) & key.used[1]) |
                                               ((all[2] < place.least) & key.used[2]));
    if ((none[0] | none[1]) != 0) {
        return false;
    }
    const auto pulses = [&](std::size_t lanes) {
        SignedLanes eighths = all[lanes] * place.step_eighths;
        eighths = eighths > kMost ? kMost : eighths;
        eighths = eighths < -kMost ? -kMost : eighths;
        return (eighths + kCentre) & key.used[lanes];
    };
    store_numbers(&channels.pulses()[0], pulses(0));
    store_numbers(&channels.pulses()[kLanes], pulses(1));
    const SignedLanes beyond_sbus = pulses(2);
    void* const behind = &channels.pulses()[kSbusChannels];
    std::memcpy(behind, &beyond_sbus, (kChannelCount - kSbusChannels) * sizeof(Pulse));
    channels.mark_first(key.alike);
    return true;
}

/// `packed` must have the length that the key says.
inline void Ibus2Decoder::unpack(std::span<const std::uint8_t> packed,
                                 ChannelFrame& channels) const {
    static_assert(kMostPacked + sizeof(std::uint64_t) <= std::tuple_size_v<Padded>);
    constexpr std::size_t kPiece = 16;
    static_assert(kMostPacked <= 3 * kPiece);
    Padded padded{};
    if (packed.size() >= kPiece) {
        // Pieces of fixed size need no loop. They may overlap.
        const std::size_t last = packed.size() - kPiece;
        std::memcpy(padded.data(), packed.data(), kPiece);
        if (last > kPiece) {
            std::memcpy(&padded[kPiece], &packed[kPiece], kPiece);
        }
        std::memcpy(&padded[last], &packed[last], kPiece);
    } else {
        std::copy(packed.begin(), packed.end(), padded.begin());
    }
    if (key_.alike != 0 && unpack_alike(padded, channels)) {
        return;
    }
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        unpack_one(padded, channel, channels);
    }
}

Ibus2Decoder::Taken Ibus2Decoder::decode(std::span<const std::uint8_t> bytes, Instant received,
                                         DecodedFrame& frame) {
    // The usual case, channels as the key says in one read. The general way gives the same.
    const std::size_t length = key_.frame_length;
    if (length != 0 && buffer_.size() == 0 && bytes.size() >= length &&
        (bytes[0] & ~unsigned{kSyncLost | kIbus2Failsafe}) == 0 &&
        bytes[kIbus2LengthAt] == length &&
        (bytes[kIbus2AddressAt] & kIbus2AddressMask) == kAllDevices &&
        ibus2_frame::crc_of(bytes.first(length - 1)) == bytes[length - 1]) {
        const std::uint8_t first = bytes[0];
        frame = {.first_byte = buffer_.first_position(), .length = length};
        frame.channels.received = received;
        frame.channels.frame_lost = (first & kSyncLost) != 0;
        frame.channels.failsafe = (first & kIbus2Failsafe) != 0;
        unpack(bytes.subspan(kPackedAt, length - kLeastIbus2Length), frame.channels);
        buffer_.pass(length);
        return {length, true};
    }
    return FramedDecoder::decode(bytes, received, frame);
}

std::size_t Ibus2Decoder::needed_bytes(std::span<const std::uint8_t> bytes) const {
    const std::uint8_t first = bytes[0];
    switch (ibus2_frame::type_of(first)) {
        case kIbus2Command:
        case kIbus2Reply:
            return first >> kIbus2CommandShift <= kLastCommand ? kCommandFrame : 0;
        case ibus2_frame::kToAll:
            break;
        default:
            return 0;
    }
    if (ibus2_frame::subtype_of(first) > ibus2_frame::kLastSubtype) {
        return 0;
    }
    if (bytes.size() <= kIbus2LengthAt) {
        return kIbus2LengthAt + 1;
    }
    const std::size_t length = bytes[kIbus2LengthAt];
    return length >= kLeastIbus2Length && length <= ibus2_frame::kLongest ? length : 0;
}

bool Ibus2Decoder::check_holds(std::span<const std::uint8_t> frame) const {
    return ibus2_frame::crc_of(frame) == 0;
}

bool Ibus2Decoder::read(std::span<const std::uint8_t> frame, ChannelFrame& channels) {
    if (ibus2_frame::type_of(frame[0]) != ibus2_frame::kToAll ||
        (frame[kIbus2AddressAt] & kIbus2AddressMask) != kAllDevices) {
        return false;
    }
    const auto packed = frame.subspan(kPackedAt, frame.size() - kLeastIbus2Length);
    const std::uint8_t subtype = ibus2_frame::subtype_of(frame[0]);
    if (subtype == kKeySubtype && packed.size() >= kKeyBytes) {
        key_ = read_key(packed);
    }
    if (subtype != kChannelsSubtype) {
        return false;
    }
    channels.frame_lost = (frame[0] & kSyncLost) != 0;
    channels.failsafe = (frame[0] & kIbus2Failsafe) != 0;
    if (frame.size() == key_.frame_length) {
        unpack(packed, channels);
    }
    return true;
}

Ibus2Decoder::Key Ibus2Decoder::read_key(std::span<const std::uint8_t> packed) {
    Key key;
    std::size_t bit = 0;
    for (std::size_t channel = 0; channel < kWireChannels; ++channel) {
        const std::size_t at = channel * kTypeBits;
        unsigned two = packed[at / 8];
        if (at / 8 + 1 < kKeyBytes) {
            two |= unsigned{packed[at / 8 + 1]} << 8U;
        }
        const unsigned type = two >> at % 8 & (kStepEighths.size() - 1);
        const unsigned bits = type & kBitsOfType;
        if (channel < kChannelCount) {
            key.types[channel] = static_cast<std::uint16_t>(type);
            if (kStepEighths[type] != 0) {
                key.channels[channel] = {.byte = static_cast<std::uint8_t>(bit / 8),
                                         .shift = static_cast<std::uint8_t>(bit % 8),
                                         .bits = static_cast<std::uint8_t>(bits),
                                         .least = least_ibus2_value(bits),
                                         .step_eighths = kStepEighths[type]};
            }
        }
        bit += bits;
    }
    key.frame_length = kLeastIbus2Length + (bit + 7) / 8;
    key.alike = alike(key, bit);
    for (std::size_t channel = 0; channel < key.alike; ++channel) {
        key.used[channel / kLanes][channel % kLanes] = -1;
    }
    return key;
}

/// `bits`: of all channels.
std::size_t Ibus2Decoder::alike(const Key& key, std::size_t bits) {
    const Place& first = key.channels[0];
    const std::size_t count = bits / kElevenBits;
    const auto channels = std::span(key.channels).first(std::min(count, kChannelCount));
    const bool all_alike =
        first.step_eighths != 0 && first.bits == kElevenBits && bits % kElevenBits == 0 &&
        count <= kChannelCount && std::ranges::all_of(channels, [&](const Place& place) {
            return place.bits == first.bits && place.step_eighths == first.step_eighths;
        });
    return all_alike ? count : 0;
}

void Ibus2Decoder::reset() {
    FramedDecoder::reset();
    key_ = {};
}

std::span<const FrameDetail> Ibus2Decoder::details() const {
    if (key_.frame_length == 0) {
        return {};
    }
    details_ = {{{"types", key_.types, true}}};
    return details_;
}

}  // namespace tribus
