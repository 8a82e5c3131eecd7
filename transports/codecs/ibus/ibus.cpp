#include "transports/codecs/ibus/ibus.h"

#include <array>
#include <cstring>
#include <memory>
#include <string>

#include "transports/codecs/ibus/wire.h"

namespace tribus {

using namespace ibus_wire;

namespace {

void put_word(std::span<std::uint8_t> bytes, std::size_t position, std::uint16_t word) {
    bytes[position] = static_cast<std::uint8_t>(word);
    bytes[position + 1] = static_cast<std::uint8_t>(word >> 8);
}

constexpr unsigned kEighthsBits = 3;
constexpr std::uint16_t kNibbleOnTop = 0xF000;
// The last eighth that rounds to 4095 us. The second vector holds the last six slots.
constexpr std::int16_t kMostSlot = kChannelMask * 8 + 3;
constexpr SignedLanes kMostOfEight{kMostSlot, kMostSlot, kMostSlot, kMostSlot,
                                   kMostSlot, kMostSlot, kMostSlot, kMostSlot};
constexpr SignedLanes kMostOfSix{kMostSlot, kMostSlot, kMostSlot, kMostSlot,
                                 kMostSlot, kMostSlot, 0,         0};

/// Pulses limited to 0 to `most` eighths, plus half a microsecond for rounding. Three bits more
/// than the wire value.
inline Lanes wire_eighths(SignedLanes pulses, const SignedLanes& most) {
    constexpr std::int16_t kHalf = 4;
    pulses = pulses > 0 ? pulses : 0;
    pulses = pulses > most ? most : pulses;
    return reinterpret_cast<Lanes>(pulses + kHalf);
}

/// Channels 15 to 18, called a to d, each repeated for the three slots that carry its nibbles.
struct Thrice {
    Lanes first;  ///< aaabbbcc
    Lanes last;   ///< cddd, then four unused lanes
};
inline Thrice thrice(const Lanes& abcd) {
    const Lanes aabc = __builtin_shufflevector(abcd, abcd, 0, 0, 1, 2, 4, 5, 6, 7);
    const Lanes abbc = __builtin_shufflevector(abcd, abcd, 0, 1, 1, 2, 4, 5, 6, 7);
    return {.first = __builtin_shufflevector(aabc, abbc, 0, 8, 1, 9, 2, 10, 3, 11),
            .last = __builtin_shufflevector(abcd, abcd, 2, 3, 3, 3, 4, 5, 6, 7)};
}

/// 0xFFFF less each byte before it (docs/protocols/ibus.md, "Servo frame"). A word is its high byte
/// times 256 plus its low byte, so word - 255 x high byte is the sum of its two bytes.
inline std::uint16_t checksum(const Lanes& first, const Lanes& last) {
    const Lanes high_bytes = (first >> 8U) + (last >> 8U);
    const Lanes less = high_bytes * 255 - (first + last);
    return static_cast<std::uint16_t>(0xFFFF - kLongestFrame - kServoCommand + total(less));
}

/// Fills each absent channel of 1 to 14 with 1500 us, and each other one with 0, which means "not
/// present".
ChannelFrame filled_ibus(const ChannelFrame& frame) {
    ChannelFrame full = frame;
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        full.set(channel, frame.channel_or(channel, channel < kSlotCount ? kCentrePulse : Pulse{}));
    }
    return full;
}

}  // namespace

IbusEncoder::IbusEncoder(std::size_t channel_count) {
    constexpr std::array<std::uint16_t, kNibblesPerChannel> kToTop{1U << 9U, 1U << 5U, 1U << 1U};
    for (std::size_t slot = 0; slot < kNibblesPerChannel * kNibbleChannels; ++slot) {
        const bool sent = kSlotCount + slot / kNibblesPerChannel < channel_count;
        nibble_to_top_[slot / kLanes][slot % kLanes] = sent ? kToTop[slot % kNibblesPerChannel] : 0;
    }
}

std::uint32_t IbusEncoder::needed_channels(const ChannelFrame& /*frame*/) const {
    return (1U << kSlotCount) - 1;
}

[[gnu::noinline]] std::size_t IbusEncoder::encode_filled(
    const ChannelFrame& frame, std::span<std::uint8_t, kLongestSerialFrame> wire) {
    return write(filled_ibus(frame), wire, Instant{});
}

std::size_t IbusEncoder::write(const ChannelFrame& frame,
                               std::span<std::uint8_t, kLongestSerialFrame> wire, Instant /*now*/) {
    if (!frame.has_first(kSlotCount)) {
        return encode_filled(frame, wire);
    }
    const auto& pulses = frame.pulses();
    const Thrice extra = thrice(wire_eighths(load_half_lanes(&pulses[kSlotCount]), kMostOfEight));
    const Lanes last = wire_eighths(load_lanes(&pulses[kLanes]), kMostOfSix) >> kEighthsBits |
                       ((extra.last * nibble_to_top_[1]) & kNibbleOnTop);
    const Lanes first = wire_eighths(load_lanes(&pulses[0]), kMostOfEight) >> kEighthsBits |
                        ((extra.first * nibble_to_top_[0]) & kNibbleOnTop);
    wire[0] = kLongestFrame;
    wire[1] = kServoCommand;
    store_wire(&wire[kSlotsAt], first);
    store_wire(&wire[kSlotsAt + sizeof first], last);
    put_word(wire, kLongestFrame - kChecksumBytes, checksum(first, last));
    return kLongestFrame;
}

namespace {

constexpr std::array<std::string_view, 2> kSlotsChoices{"nibbles", "plain"};
constexpr std::array<std::string_view, 2> kChannelsChoices{"14", "18"};
constexpr std::array kIbusSettings{
    baud_setting("115200", "100000"),
    Setting{.key = "slots",
            .type = SettingType::choice,
            .fallback = "\"nibbles\"",
            .choices = kSlotsChoices,
            .scope = SettingScope::input,
            .help = "How channels lie in a frame. `nibbles`: 12 bits a slot, channels 15 to 18 "
                    "in the high nibbles; `plain`: 16 bits a slot, at most 14 channels",
            .example = "\"plain\""},
    Setting{.key = "channels",
            .type = SettingType::integer,
            .fallback = "14",
            .choices = kChannelsChoices,
            .scope = SettingScope::output,
            .help = "How many channels are sent. Every reader knows 14; ArduPilot reads a frame "
                    "of 18 channels as failsafe",
            .example = "18"},
};

constexpr std::array kIbusBeginnings{FrameBeginning{0x20, 0x40}};

bool is_plain(const SettingValues& settings) {
    return settings.get_or<std::string>("slots", "nibbles") == "plain";
}

std::uint32_t possible_ibus_channels(const SettingValues& settings) {
    return is_plain(settings) ? first_channels(kSlotCount) : kAllChannels;
}

AnyDecoder make_ibus_decoder(const SettingValues& settings) {
    return std::make_unique<IbusDecoder>(is_plain(settings) ? IbusSlots::plain
                                                            : IbusSlots::nibbles);
}

AnyEncoder make_ibus_encoder(const SettingValues& settings) {
    return std::make_unique<IbusEncoder>(
        static_cast<std::size_t>(settings.get_or<std::int64_t>("channels", 14)));
}

}  // namespace

// Real receivers send every 7.7 ms, one every 4.0 ms; readers that wait for 2 to 3 ms of silence
// need 7 ms (docs/protocols/ibus.md, "Period and gaps").
const Protocol kIbusProtocol{
    .name = "ibus",
    .title = "i.Bus",
    .description = "FlySky i.Bus servo frames, 14 or 18 channels",
    .line = {.baud = 115200, .parity = Parity::none, .stop_bits = 1},
    .beginnings = kIbusBeginnings,
    .settings = kIbusSettings,
    .longest_frame = kLongestFrame,
    .default_period = std::chrono::milliseconds(7),
    .least_period = std::chrono::milliseconds(4),
    .signals_failsafe = never_signals_failsafe,
    .sure_channels = always_has_first<kSlotCount>,
    .possible_channels = possible_ibus_channels,
    .make_decoder = make_ibus_decoder,
    .make_encoder = make_ibus_encoder,
};

}  // namespace tribus
