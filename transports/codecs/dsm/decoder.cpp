#include <algorithm>
#include <array>
#include <bit>
#include <utility>

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

constexpr Lanes each(std::uint16_t number) {
    return Lanes{} + number;
}

/// A step of Spektrum is 80/17 eighths, and 1500 us stands at 1024. Betaflight: a step is 4
/// eighths, and 988 us stands at 0.
constexpr DsmLine kSpektrumLine{
    .seventeenths = each(12), .rounding = each(11), .least_eighths = each(7181)};
constexpr DsmLine kBetaflightLine{
    .seventeenths = each(0), .rounding = each(0), .least_eighths = each(988 * 8)};

// The nearest eighth of each value; the numerator of the exact form is positive.
static_assert([] {
    for (int value = 0; value < 2048; ++value) {
        const int nearest = ((2 * value - 2 * 1024) * 80 + 24'000 * 17 + 17) / (2 * 17);
        if (4 * value + (12 * value + 11) / 17 + 7181 != nearest) {
            return false;
        }
    }
    return true;
}());

/// Divides numbers of up to 15 bits by 17.
Lanes seventeenth(Lanes numbers) {
    // 2^20 / 17, rounded up; loops over lanes become one multiplication.
    constexpr std::uint32_t kReciprocal = 61'681;
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
        numbers[lane] = static_cast<std::uint16_t>(numbers[lane] * kReciprocal >> 16U);
    }
    return numbers >> 4U;
}

}  // namespace

DsmDecoder::DsmDecoder(DsmScale scale, DsmResolution resolution)
    : line_(scale == DsmScale::spektrum ? kSpektrumLine : kBetaflightLine),
      resolution_(resolution) {
    values_.frame_lost = false;
    values_.failsafe = false;
}

DsmDecoder::Taken DsmDecoder::decode(std::span<const std::uint8_t> bytes, Instant received,
                                     DecodedFrame& frame) {
    // The usual case, a frame that counts in one read. The general way gives the same.
    if (received <= usual_until_ && aligned_ && buffer_.size() == 0 &&
        bytes.size() >= kDsmFrameBytes) {
        Known* const known = recognise(bytes.data());
        if (known != nullptr && known->counts) {
            keep(*known, bytes.data(), received);
            give(bytes.data(), received, frame);
            buffer_.pass(kDsmFrameBytes);
            return {kDsmFrameBytes, true};
        }
    }
    return decode_any(bytes, received, frame);
}

[[gnu::noinline]] DsmDecoder::Taken DsmDecoder::decode_any(std::span<const std::uint8_t> bytes,
                                                           Instant received, DecodedFrame& frame) {
    buffer_.open(bytes);
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
        if (std::exchange(needs_pause_, false)) {
            break_row();
        }
        skipped_bytes_ += kDsmFrameBytes;
    } else if (needs_pause_ && waits_for_pause(received)) {
        return Step::wait;
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

/// Whether the frame at the front counts with the pause behind it. If more bytes follow, or it is
/// another frame, the row is over.
bool DsmDecoder::waits_for_pause(Instant received) {
    const Known* const known = recognise(buffer_.view(0, kDsmFrameBytes).data());
    if (known != nullptr && known->counts && received - latest_frame_ <= kSilence &&
        !buffer_.see(kDsmFrameBytes + 1)) {
        waits_since_ = received;
        return true;
    }
    needs_pause_ = false;
    break_row();
    return false;
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
    known->counts = true;
    channels_in_row_ |= known->layout.channels();
    keep(*known, wire, received);
    agreeing_ += agreeing_ < kAgreeingFrames ? 1 : 0;
    const bool counts =
        agreeing_ >= kAgreeingFrames && (channels_in_row_ & kPrimaryChannels) == kPrimaryChannels;
    rejected_[kUnproven].count += counts ? 0U : 1U;
    if (counts) {
        remove_old(received);
    }
    return counts;
}

/// Keeps the values of a plausible frame with this layout.
inline void DsmDecoder::keep(Known& known, const std::uint8_t* wire, Instant received) {
    latest_frame_ = received;
    known.latest = received;
    known.order = ++frames_;
    const DsmLayout& layout = known.layout;
    // The first two bytes are no word, so word n stands in lane n + 1.
    const auto came = std::bit_cast<std::array<Pulse, kLanes>>(
        eighths_of(reinterpret_cast<Lanes>(load_wire(wire)), layout.resolution()));
    auto& pulses = values_.pulses();
    for (std::size_t word = 0; word < kDsmWords; ++word) {
        pulses[layout.words()[word]] = came[1 + word];
    }
    pulses[DsmLayout::kNoChannel] = Pulse{};
    if ((values_.absent() & layout.channels()) != 0) {
        mark_present(layout.channels());
    }
}

/// The words of a frame have their high byte first.
inline Lanes DsmDecoder::eighths_of(Lanes words, DsmResolution resolution) const {
    constexpr std::uint16_t kElevenBits = 0x7FF;
    words = words << 8U | words >> 8U;
    if (resolution == DsmResolution::bits_10) {
        words += words;  // ten bits are the upper ones of eleven
    }
    const Lanes values = words & kElevenBits;
    return values * std::uint16_t{4} + seventeenth(values * line_.seventeenths + line_.rounding) +
           line_.least_eighths;
}

void DsmDecoder::mark_present(std::uint32_t channels) {
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
DsmDecoder::Known* DsmDecoder::meet(const std::uint8_t* wire, Instant received) {
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
    if (broken_row_) {
        broken_row_->layouts &= ~(1U << static_cast<unsigned>(&place - known_.data()));
    }
    place = {.layout = *layout, .order = ++frames_, .used = true};
    if (agrees) {
        return &place;
    }
    ++rejected_[kUnproven].count;
    break_row();
    aligned_ = false;
    return nullptr;
}

/// Makes channels absent that came too long ago.
void DsmDecoder::remove_old(Instant received) {
    std::uint32_t fresh = 0;
    usual_until_ = received + kChannelLasts;
    for (const Known& known : known_) {
        const Instant until = known.latest + kChannelLasts;
        if (known.counts && received <= until) {
            fresh |= known.layout.channels();
            usual_until_ = std::min(usual_until_, until);
        }
    }
    values_.remove_all(kAllChannels & ~values_.absent() & ~fresh);
}

/// Fills `frame` with the frame at the front, which counts.
inline void DsmDecoder::give(const std::uint8_t* wire, Instant received, DecodedFrame& frame) {
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

/// A frame is whole before the pause. So what is left was cut off, or was never a frame, but for
/// the one that waits.
bool DsmDecoder::silence(DecodedFrame& frame) {
    buffer_.open({});
    bool counts = false;
    if (needs_pause_ && aligned_ && buffer_.size() == kDsmFrameBytes && !buffer_.any_damaged()) {
        needs_pause_ = false;
        const auto wire = buffer_.view(0, kDsmFrameBytes);
        counts = take(wire.data(), waits_since_);
        if (counts) {
            give(wire.data(), waits_since_, frame);
        }
        buffer_.drop(kDsmFrameBytes);
    } else if (buffer_.size() != 0) {
        rejected_[kCut].count += aligned_ ? 1U : 0U;
        break_row();
        skip(buffer_.size());
    }
    resume_row();
    burst_begin_ = buffer_.first_position();
    buffer_.close();
    aligned_ = true;
    return counts;
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
