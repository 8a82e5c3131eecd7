#include "transports/codecs/ibus.h"

#include <algorithm>
#include <array>
#include <memory>
#include <string>

#include "transports/codecs/ibus_wire.h"

namespace tribus {

using namespace ibus_wire;

namespace {

void put_word(std::span<std::uint8_t> bytes, std::size_t position, std::uint16_t word) {
    bytes[position] = static_cast<std::uint8_t>(word);
    bytes[position + 1] = static_cast<std::uint8_t>(word >> 8);
}

/// Whole microseconds, 0 to 4095.
std::uint16_t wire_microseconds(Pulse pulse) {
    constexpr std::int16_t kMost = kChannelMask * 8 + 3;  // the last eighth that rounds to 4095
    const auto eighths = static_cast<std::int16_t>(pulse.eighths());
    return static_cast<std::uint16_t>((std::clamp<std::int16_t>(eighths, 0, kMost) + 4) >> 3);
}

/// The slots, 12 bits each, of a frame without absent channels.
inline std::array<std::uint64_t, kGroupsPerFrame> slots_of(const ChannelFrame& frame) {
    std::array<std::uint16_t, kGroupsPerFrame * kWordsPerGroup> words;
    for (std::size_t slot = 0; slot < words.size(); ++slot) {
        words[slot] = wire_microseconds(frame.pulses()[slot]);
    }
    auto groups = to_words(words);
    groups.back() &= 0xFFFFFFFF;  // two slots; what stands behind them are channels 15 and 16
    return groups;
}

/// With 1500 us for each absent channel of 1 to 14, and 0, which is not present, for the others.
ChannelFrame filled(const ChannelFrame& frame) {
    ChannelFrame full = frame;
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        full.set(channel, frame.channel_or(channel, channel < kSlotCount ? kCentrePulse : Pulse{}));
    }
    return full;
}

/// Channels 15 to 18 on top of three slots each: a copy of the value for each slot, shifted so that
/// the slot's own nibble comes out on top.
inline void put_nibbles(const ChannelFrame& frame,
                        std::array<std::uint64_t, kGroupsPerFrame>& groups) {
    constexpr std::uint64_t kApart = 1ULL << 36U | 1ULL << 24U | 1ULL << 12U;
    std::array<std::uint16_t, kNibbleChannels> values;
    for (std::size_t extra = 0; extra < kNibbleChannels; ++extra) {
        values[extra] = wire_microseconds(frame.pulses()[kSlotCount + extra]);
    }
    const std::uint64_t a = values[0] * kApart;
    const std::uint64_t b = values[1] * kApart;
    const std::uint64_t c = values[2] * kApart;
    const std::uint64_t d = values[3] * kApart;
    groups[0] |= (a | b << 48U) & kNibbles;
    groups[1] |= (b >> 16U | c << 32U) & kNibbles;
    groups[2] |= (c >> 32U | d << 16U) & kNibbles;
}

}  // namespace

[[gnu::noinline]] std::size_t IbusEncoder::encode_filled(
    const ChannelFrame& frame, std::span<std::uint8_t, kLongestSerialFrame> wire) const {
    return encode(filled(frame), wire);
}

std::size_t IbusEncoder::encode(const ChannelFrame& frame,
                                std::span<std::uint8_t, kLongestSerialFrame> wire) const {
    if (!frame.has_first(channel_count_)) {
        return encode_filled(frame, wire);
    }
    auto groups = slots_of(frame);
    if (channel_count_ > kSlotCount) {
        put_nibbles(frame, groups);
    }
    std::uint64_t sums = 0;
    for (std::size_t group = 0; group < groups.size(); ++group) {
        sums += sum_by_words(groups[group]);
        store_word(&wire[kSlotsAt + group * kGroupBytes], groups[group]);
    }
    wire[0] = kLongestFrame;
    wire[1] = kServoCommand;
    put_word(wire, kLongestFrame - kChecksumBytes,
             static_cast<std::uint16_t>(0xFFFF - kLongestFrame - kServoCommand - total(sums)));
    return kLongestFrame;
}

namespace {

constexpr std::array<std::string_view, 2> kSlotsChoices{"nibbles", "plain"};
constexpr std::array<std::string_view, 2> kChannelsChoices{"14", "18"};
constexpr std::array kSettings{
    Setting{.key = "baud",
            .type = SettingType::integer,
            .fallback = "115200",
            .least = 9600,
            .most = 1000000,
            .help = "Bit rate of the line"},
    Setting{.key = "slots",
            .type = SettingType::choice,
            .fallback = "\"nibbles\"",
            .choices = kSlotsChoices,
            .scope = SettingScope::input,
            .help = "nibbles: 12 bits a slot, channels 15 to 18 in the high nibbles; plain: 16 "
                    "bits a slot, at most 14 channels"},
    Setting{.key = "channels",
            .type = SettingType::integer,
            .fallback = "14",
            .choices = kChannelsChoices,
            .scope = SettingScope::output,
            .help = "14, which every reader knows, or 18 (ArduPilot reads an 18-channel frame as "
                    "failsafe)"},
};

std::unique_ptr<Decoder> make_decoder(const SettingValues& settings) {
    const bool plain = settings.get_or<std::string>("slots", "nibbles") == "plain";
    return std::make_unique<IbusDecoder>(plain ? IbusSlots::plain : IbusSlots::nibbles);
}

std::unique_ptr<Encoder> make_encoder(const SettingValues& settings) {
    return std::make_unique<IbusEncoder>(
        static_cast<std::size_t>(settings.get_or<std::int64_t>("channels", 14)));
}

}  // namespace

// Period: real receivers send each 7.7 ms, one each 4.0 ms; readers that wait for 2 to 3 ms of
// silence need 7 (1.4).
const Protocol kIbusProtocol{
    .name = "ibus",
    .description = "FlySky i.Bus servo frames, 14 or 18 channels",
    .line = {.baud = 115200, .parity = Parity::none, .stop_bits = 1},
    .settings = kSettings,
    .longest_frame = kLongestFrame,
    .default_period = std::chrono::milliseconds(7),
    .least_period = std::chrono::milliseconds(4),
    .says_failsafe = never_says_failsafe,
    .make_decoder = make_decoder,
    .make_encoder = make_encoder,
};

}  // namespace tribus
