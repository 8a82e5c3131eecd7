#include <algorithm>

#include "transports/codecs/big_endian.h"
#include "transports/codecs/dsm/dsm.h"

namespace tribus {
namespace {

constexpr std::uint32_t kPrimaryChannels = 0x0F;
constexpr std::size_t kDsmSystemAt = 1;

/// Whether a documented system byte says this resolution. Internal satellites send other bytes.
bool system_says(std::uint8_t system, DsmResolution resolution) {
    constexpr std::uint8_t kDsm2With10Bits = 0x01;
    constexpr std::uint8_t kDsm2With11Bits = 0x12;
    constexpr std::uint8_t kDsmxEach22Ms = 0xA2;
    constexpr std::uint8_t kDsmxEach11Ms = 0xB2;
    return resolution == DsmResolution::bits_10
               ? system == kDsm2With10Bits
               : system == kDsm2With11Bits || system == kDsmxEach22Ms || system == kDsmxEach11Ms;
}

DsmWire dsm_wire(const std::uint8_t* wire) {
    return DsmWire(wire, kDsmFrameBytes);
}

/// Pulses of values of 11 bits. Spektrum: 1500 us at the centre, 1.7 steps a microsecond.
/// Betaflight: 988 us at 0, 2 steps a microsecond.
constexpr DsmPulses pulses_of(DsmScale scale) {
    DsmPulses pulses{};
    for (std::size_t value = 0; value < pulses.size(); ++value) {
        const auto steps = static_cast<std::int64_t>(value);
        // Floor of a half more; the numerator is positive.
        const std::int64_t spektrum = ((2 * steps - 2 * 1024) * 80 + 24'000 * 17 + 17) / (2 * 17);
        const std::int64_t betaflight = 988 * 8 + steps * 4;
        pulses[value] = Pulse::from_eighths(scale == DsmScale::spektrum ? spektrum : betaflight);
    }
    return pulses;
}

constexpr DsmPulses kSpektrumPulses = pulses_of(DsmScale::spektrum);
constexpr DsmPulses kBetaflightPulses = pulses_of(DsmScale::betaflight);

}  // namespace

DsmDecoder::DsmDecoder(DsmScale scale, DsmResolution resolution)
    : pulses_(scale == DsmScale::spektrum ? kSpektrumPulses : kBetaflightPulses),
      resolution_(resolution) {
    values_.frame_lost = false;
    values_.failsafe = false;
}

DsmDecoder::Taken DsmDecoder::decode(std::span<const std::uint8_t> bytes, Instant received,
                                     DecodedFrame& frame) {
    // The usual case, a frame in one read. The general way gives the same.
    std::size_t passed = 0;
    if (aligned_ && buffer_.size() == 0 && bytes.size() >= kDsmFrameBytes) {
        const bool counts = take(bytes.data(), received);
        if (counts) {
            give(bytes.data(), received, frame);
        }
        buffer_.pass(kDsmFrameBytes);
        if (counts) {
            return {kDsmFrameBytes, true};
        }
        passed = kDsmFrameBytes;
    }
    buffer_.open(bytes.subspan(passed));
    Step stepped = Step::again;
    while (stepped == Step::again) {
        stepped = step(received, frame);
    }
    return {bytes.size() - buffer_.close().size(), stepped == Step::frame};
}

DsmDecoder::Step DsmDecoder::step(Instant received, DecodedFrame& frame) {
    if (!aligned_) {
        return search(received, frame);
    }
    if (!buffer_.see(kDsmFrameBytes)) {
        return Step::wait;
    }
    bool counts = false;
    if (buffer_.any_damaged() && buffer_.damaged(0, kDsmFrameBytes)) {
        skipped_bytes_ += kDsmFrameBytes;
    } else {
        const auto wire = buffer_.view(0, kDsmFrameBytes);
        counts = take(wire.data(), received);
        if (counts) {
            give(wire.data(), received, frame);
        }
    }
    buffer_.drop(kDsmFrameBytes);
    return counts ? Step::frame : Step::again;
}

/// Whether frames in a row from `start` on prove the place. All kSearchFrames of them must be
/// there.
bool DsmDecoder::proven_at(std::size_t start) const {
    const std::uint8_t system = buffer_[start + kDsmSystemAt];
    std::array<DsmLayout, kSearchFrames> layouts;
    for (std::size_t i = 0; i < kSearchFrames; ++i) {
        const std::size_t at = start + i * kDsmFrameBytes;
        if (buffer_[at + kDsmSystemAt] != system || buffer_.damaged(at, kDsmFrameBytes)) {
            return false;
        }
        const auto layout =
            DsmLayout::of(buffer_.view(at, kDsmFrameBytes).first<kDsmFrameBytes>(), resolution_);
        if (!layout || !system_says(system, layout->resolution())) {
            return false;
        }
        layouts[i] = *layout;
    }
    const auto agrees = [&](const DsmLayout& layout) {
        return layout.agrees(layouts[0]) || layout.agrees(layouts[1]);
    };
    const std::uint32_t channels = layouts[2].channels() | layouts[3].channels();
    return agrees(layouts[2]) && agrees(layouts[3]) &&
           (channels & kPrimaryChannels) == kPrimaryChannels;
}

/// One of the next 16 places must be proven, and only one: a place that is off by a word can look
/// like a frame too.
DsmDecoder::Step DsmDecoder::search(Instant received, DecodedFrame& frame) {
    if (!buffer_.see(kSearchBytes)) {
        return Step::wait;
    }
    std::size_t proven = 0;
    std::size_t found = 0;
    for (std::size_t start = 0; start < kDsmFrameBytes; ++start) {
        if (proven_at(start)) {
            ++proven;
            found = start;
        }
    }
    if (proven != 1) {
        skip(kDsmFrameBytes);
        return Step::again;
    }
    skip(found);
    forget();
    bool counts = false;
    for (std::size_t last = kSearchFrames - 1, i = 0; i <= last; ++i) {
        const auto wire = buffer_.view(0, kDsmFrameBytes);
        counts = take(wire.data(), received);
        if (counts && i == last) {
            give(wire.data(), received, frame);
        }
        buffer_.drop(kDsmFrameBytes);
    }
    aligned_ = true;
    return counts ? Step::frame : Step::again;
}

/// Takes a frame that begins in its place. Returns whether it counts.
bool DsmDecoder::take(const std::uint8_t* wire, Instant received) {
    if (received - latest_frame_ > kSilence) {
        forget();
    }
    Known* known = recognise(wire);
    if (known == nullptr) {
        known = meet(wire, received);
    }
    if (known == nullptr) {
        return false;
    }
    latest_frame_ = received;
    known->latest = received;
    known->order = ++frames_;
    known->counts = true;
    keep_values(known->layout, wire);
    agreeing_ += agreeing_ < kAgreeingFrames ? 1 : 0;
    const bool counts =
        agreeing_ >= kAgreeingFrames && (channels_in_row_ & kPrimaryChannels) == kPrimaryChannels;
    rejected_[kUnproven].count += counts ? 0U : 1U;
    return counts;
}

/// Ten bits are the upper ones of eleven.
inline void DsmDecoder::keep_values(const DsmLayout& layout, const std::uint8_t* wire) {
    const std::uint32_t channels = layout.channels();
    channels_in_row_ |= channels;
    const bool bits_10 = layout.resolution() == DsmResolution::bits_10;
    const unsigned doubling = bits_10 ? 1 : 0;
    const unsigned mask = bits_10 ? 0x3FF : 0x7FF;
    auto& pulses = values_.pulses();
    for (std::size_t word = 0; word < kDsmWords; ++word) {
        const unsigned bits = big_endian_at(DsmWire(wire, kDsmFrameBytes), 2 + 2 * word);
        pulses[layout.words()[word]] = pulses_[(bits & mask) << doubling];
    }
    pulses[DsmLayout::kNoChannel] = Pulse{};
    if ((values_.absent() & channels) != 0) {
        mark_present(channels);
    }
}

[[gnu::noinline]] void DsmDecoder::mark_present(std::uint32_t channels) {
    for (std::size_t channel = 0; channel < kDsmChannels; ++channel) {
        if ((channels >> channel & 1U) != 0) {
            values_.set(channel, values_.pulses()[channel]);
        }
    }
}

DsmDecoder::Known* DsmDecoder::recognise(const std::uint8_t* wire) {
    for (Known& known : known_) {
        if (known.layout.fits(wire)) {
            return &known;
        }
    }
    return nullptr;
}

/// A frame whose layout is new. Returns it if it agrees with a known one.
[[gnu::noinline]] DsmDecoder::Known* DsmDecoder::meet(const std::uint8_t* wire, Instant received) {
    const auto layout = DsmLayout::of(dsm_wire(wire), resolution_);
    if (!layout) {
        ++rejected_[kImplausible].count;
        skipped_bytes_ += kDsmFrameBytes;
        break_row();
        aligned_ = false;
        return nullptr;
    }
    latest_frame_ = received;
    if (std::ranges::any_of(known_, [&](const Known& known) {
            return known.used && known.layout.resolution() != layout->resolution();
        })) {
        forget();
    }
    const bool agrees = std::ranges::any_of(
        known_, [&](const Known& known) { return known.used && known.layout.agrees(*layout); });
    Known& place = *std::ranges::min_element(known_, {}, &Known::order);
    place = {.layout = *layout, .order = ++frames_, .used = true};
    if (agrees) {
        return &place;
    }
    ++rejected_[kUnproven].count;
    break_row();
    aligned_ = false;
    return nullptr;
}

/// Fills `frame` with the frame at the front, which counts.
void DsmDecoder::give(const std::uint8_t* wire, Instant received, DecodedFrame& frame) {
    std::uint32_t fresh = 0;
    for (const Known& known : known_) {
        if (known.counts && received - known.latest <= kChannelLasts) {
            fresh |= known.layout.channels();
        }
    }
    values_.remove_all(kAllChannels & ~values_.absent() & ~fresh);
    std::copy_n(wire, kDsmFrameBytes, latest_.begin());
    frame.first_byte = buffer_.first_position();
    frame.length = kDsmFrameBytes;
    frame.channels = values_;
    frame.channels.received = received;
}

void DsmDecoder::skip(std::size_t count) {
    skipped_bytes_ += count;
    buffer_.drop(count);
}

/// Frames count again only after others have agreed; older values do not count any more.
void DsmDecoder::break_row() {
    agreeing_ = 0;
    channels_in_row_ = 0;
    for (Known& known : known_) {
        known.counts = false;
    }
}

void DsmDecoder::forget() {
    break_row();
    known_ = {};
}

/// A frame is whole before the pause. So what is left was cut off, or was never a frame.
bool DsmDecoder::silence(DecodedFrame& /*frame*/) {
    buffer_.open({});
    if (buffer_.size() != 0) {
        rejected_[kCut].count += aligned_ ? 1U : 0U;
        break_row();
        skip(buffer_.size());
    }
    buffer_.close();
    aligned_ = true;
    return false;
}

void DsmDecoder::damaged_byte() {
    buffer_.append_damaged();
    ++rejected_[kDamaged].count;
}

void DsmDecoder::reset() {
    buffer_.open({});
    skip(buffer_.size());
    buffer_.close();
    forget();
    aligned_ = false;
}

std::span<const FrameDetail> DsmDecoder::details() const {
    for (std::size_t i = 0; i < kDsmWords; ++i) {
        detail_values_[2 + i] = big_endian_at(latest_, 2 + 2 * i);
    }
    detail_values_[0] = latest_[0];
    detail_values_[1] = latest_[kDsmSystemAt];
    const std::span values(detail_values_);
    details_ = {{{"fades", values.subspan(0, 1), false},
                 {"system", values.subspan(1, 1), false},
                 {"words", values.subspan(2), true}}};
    return details_;
}

}  // namespace tribus
